/* Inside the plot folder: text in XML. */
#ifndef SGA_PLOT_PLOT_TEXT_H
#define SGA_PLOT_PLOT_TEXT_H

struct sga_buf;

/* Appends UTF-8 text as character data; characters that XML 1.0 does not allow are left out, and so is
 * what is not UTF-8. */
void plot_escape(const char *text, struct sga_buf *out);

#endif
