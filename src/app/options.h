/* Command lines from tables: `--name value`, `--name=value`, `-n value`, flags, `--`, operands in any order;
 * `--help` and `--man` are printed from the same table, so that they cannot disagree. */
#pragma once


#include "cache/frame/settings.h"

typedef enum sl_option_kind {
    SL_OPTION_FLAG,    /* bool *: set to true */
    SL_OPTION_TEXT,    /* const char **  */
    SL_OPTION_REAL,    /* double *, finite, within [minimum, maximum] */
    SL_OPTION_COUNT,   /* uint64_t *, decimal, within [minimum, maximum] */
    SL_OPTION_CHOICE,  /* int *: the number of the choice */
    SL_OPTION_SIZE,    /* int[2]: WxH, each 1 to 32768 */
    SL_OPTION_VECTOR,  /* float[3]: X,Y,Z, finite */
    SL_OPTION_SETTING, /* sl_settings *: the method's `setting` of them */
    SL_OPTION_SET      /* sl_settings *: that of them which the value names, NAME=VALUE */
} sl_option_kind;

typedef struct sl_option {
    const char *name;           /* without the dashes */
    char letter;                /* short form, or 0 */
    sl_option_kind kind;
    void *value;
    bool *given;                /* set to true where the option occurs; or NULL */
    const char *metavar;        /* "N"; NULL for flags */
    const char *help;           /* one line; ends with the default in brackets where there is one; NULL for
                                   settings, whose own it is */
    double minimum, maximum;    /* REAL and COUNT; both 0: no bounds but the type's */
    const char *choices;        /* CHOICE: "clip|reinhard" */
    const sl_setting *setting;  /* SETTING */
} sl_option;

/* Rows of a table of options. */
#define SL_FLAG(n, v, h) {.name = n, .kind = SL_OPTION_FLAG, .value = v, .help = h}
#define SL_TEXT(n, l, v, unit, h) \
    {.name = n, .letter = l, .kind = SL_OPTION_TEXT, .value = v, .metavar = unit, .help = h}
#define SL_REAL(n, v, g, unit, least, most, h)                                                 \
    {                                                                                          \
        .name = n, .kind = SL_OPTION_REAL, .value = v, .given = g, .metavar = unit, .help = h, \
        .minimum = least, .maximum = most                                                      \
    }
#define SL_NUMBER(n, l, v, unit, least, most, h) \
    {.name = n, .letter = l, .kind = SL_OPTION_COUNT, .value = v, .metavar = unit, .help = h, \
     .minimum = least, .maximum = most}
#define SL_CHOICE(n, v, unit, words, h) \
    {.name = n, .kind = SL_OPTION_CHOICE, .value = v, .metavar = unit, .help = h, .choices = words}

#define SL_VECTOR(n, v, g, h) \
    {.name = n, .kind = SL_OPTION_VECTOR, .value = v, .given = g, .metavar = "X,Y,Z", .help = h}
#define SL_PIXELS(n, l, v, h) \
    {.name = n, .letter = l, .kind = SL_OPTION_SIZE, .value = v, .metavar = "WxH", .help = h}

/* Options by which a scene is read, of every command that shows one. It must stay where it is: what is taken
 * points into it. */
typedef struct sl_reading {
    bool allow_outside;
    int up_axis;
    double fov_degrees;
    sl_viewpoint view;
    sl_load_options load; /* once the command line has been read */
} sl_reading;

typedef struct sl_command_line {
    const char *usage;        /* "softlux render SCENE -o FILE [options]" */
    const char *summary;      /* what it does: printed under the usage */
    const char *details;      /* printed under the options; or NULL */
    const sl_option *options; /* ends with a NULL name */
    int operands_min, operands_max;
    sl_reading *reading;      /* its options are the command's, too; or NULL */
    sl_settings *settings;    /* of methods, if the command takes them: options, too; or NULL */
    bool *quality_given;      /* set to true where --quality occurs; or NULL */
} sl_command_line;

/* Parses argv[0..argc). operands receives up to operands_max strings. Returns true to go on; otherwise
 * *status is the exit status (0 after --help and --man, 2 after a mistake, which has been described on stderr
 * in one line). */
bool sl_options_parse(const sl_command_line *line, int argc, char **argv, const char **operands,
                      int *operand_count, int *status);

/* Hands out every option of a command as a help page shows it. */
typedef void (*sl_option_printer)(char letter, const char *name, const char *unit, const char *help);
void sl_each_option(const sl_command_line *line, sl_option_printer print);
