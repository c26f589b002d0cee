/* The page's files: PAGE_FILE(name, ending, type), as they lie in page/ and under / of the address; index.html
 * is / itself. Symbols are named after the path, so names are made of letters, digits and _. */
PAGE_FILE(index, html, "text/html; charset=utf-8")
PAGE_FILE(page, css, "text/css; charset=utf-8")
PAGE_FILE(page, js, "text/javascript; charset=utf-8")
