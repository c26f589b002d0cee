# Installing, and the pages of the public header; the Makefile includes it.

PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
LIBEXECDIR ?= $(PREFIX)/libexec
MANDIR ?= $(PREFIX)/share/man
DOCDIR ?= $(PREFIX)/share/doc/softlux
DESTDIR ?=
# Programs are stripped; the libraries keep what a debugger asks for.
INSTALL ?= install
INSTALL_PROGRAM ?= $(INSTALL) -s -m 755

VERSION := $(shell sed -n 's/^.define SL_VERSION "\(.*\)"/\1/p' include/softlux.h)
MAJOR := $(firstword $(subst ., ,$(VERSION)))
COMMANDS = $(shell $(BUILD)/softlux --help | sed -n '/^commands:/,/^$$/s/^  \([a-z-]*\) .*/\1/p')

# The installed library has another object that says where softlux-import is: it is linked anew.
STAGE := $(BUILD)/install
PATH_OBJECT := $(BUILD)/o/src/scene/importer_path.o
CMAKEDIR = $(LIBDIR)/cmake/softlux
# Writes a file of packaging/, which others find the library by, into a folder.
fill = @sed 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(LIBDIR)|; s|@VERSION@|$(VERSION)|; s|@MAJOR@|$(MAJOR)|; \
  s|@LIBS@|$(strip $(LIBS) $(OPENMP))|; \
  s|@INCLUDE@|$(shell realpath -m --relative-to=$(CMAKEDIR) $(PREFIX)/include)|' \
  packaging/$(1).in > $(DESTDIR)$(2)/$(1)

.PHONY: install uninstall doc

install: all ## into PREFIX (default /usr/local), DESTDIR respected; make uninstall removes
	@mkdir -p $(STAGE)
	@$(CC) $(ALL_CFLAGS) -DSL_IMPORTER='"$(LIBEXECDIR)/softlux-import"' -c src/scene/importer_path.c \
	  -o $(STAGE)/importer_path.o
	@cp $(BUILD)/libsoftlux.a $(STAGE)/libsoftlux.a && $(AR) rs $(STAGE)/libsoftlux.a $(STAGE)/importer_path.o
	@$(CC) $(OPTIMISE) $(OPENMP) -o $(STAGE)/softlux $(APP_OBJECTS) $(STAGE)/libsoftlux.a $(LDFLAGS) $(LIBS) \
	  $(SERVE_LIBS)
	@$(CC) $(OPTIMISE) $(OPENMP) $(SHARED) -o $(STAGE)/libsoftlux.so $(STAGE)/importer_path.o \
	  $(filter-out $(PATH_OBJECT),$(LIBRARY_OBJECTS)) $(LDFLAGS) $(LIBS)
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(LIBEXECDIR) $(DESTDIR)$(LIBDIR)/pkgconfig \
	  $(DESTDIR)$(CMAKEDIR) $(DESTDIR)$(PREFIX)/include $(DESTDIR)$(MANDIR)/man1 $(DESTDIR)$(DOCDIR)
	install -m 644 LICENSE NOTICES CHANGELOG.md $(DESTDIR)$(DOCDIR)
	$(INSTALL_PROGRAM) $(STAGE)/softlux $(DESTDIR)$(PREFIX)/bin/softlux
	$(INSTALL_PROGRAM) $(BUILD)/softlux-import $(DESTDIR)$(LIBEXECDIR)/softlux-import
	install -m 644 include/softlux.h $(DESTDIR)$(PREFIX)/include/softlux.h
	install -m 644 $(STAGE)/libsoftlux.a $(DESTDIR)$(LIBDIR)/libsoftlux.a
	install -m 755 $(STAGE)/libsoftlux.so $(DESTDIR)$(LIBDIR)/libsoftlux.so.$(VERSION)
	ln -sf libsoftlux.so.$(VERSION) $(DESTDIR)$(LIBDIR)/libsoftlux.so.$(MAJOR)
	ln -sf libsoftlux.so.$(MAJOR) $(DESTDIR)$(LIBDIR)/libsoftlux.so
	$(call fill,softlux.pc,$(LIBDIR)/pkgconfig)
	$(call fill,softlux-config.cmake,$(CMAKEDIR))
	$(call fill,softlux-config-version.cmake,$(CMAKEDIR))
	@$(BUILD)/softlux --man > $(DESTDIR)$(MANDIR)/man1/softlux.1
	@for c in $(COMMANDS); do $(BUILD)/softlux $$c --man > $(DESTDIR)$(MANDIR)/man1/softlux-$$c.1 || exit; done

uninstall:
	rm -f $(DESTDIR)$(PREFIX)/bin/softlux $(DESTDIR)$(LIBEXECDIR)/softlux-import \
	  $(DESTDIR)$(PREFIX)/include/softlux.h $(DESTDIR)$(LIBDIR)/libsoftlux.* \
	  $(DESTDIR)$(LIBDIR)/pkgconfig/softlux.pc \
	  $(DESTDIR)$(MANDIR)/man1/softlux.1 $(DESTDIR)$(MANDIR)/man1/softlux-*.1
	rm -rf $(DESTDIR)$(DOCDIR) $(DESTDIR)$(CMAKEDIR)

doc: ## the contract of every public function as pages, into build/doc/html; a warning is a failure
	@mkdir -p $(BUILD)/doc
	@(cat packaging/Doxyfile; echo 'OUTPUT_DIRECTORY = $(BUILD)/doc'; echo 'PROJECT_NUMBER = $(VERSION)'; \
	  echo 'WARN_AS_ERROR = FAIL_ON_WARNINGS') | doxygen -
