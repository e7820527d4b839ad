/* A tradeoff, out of a result's text, as a table or as an image. */
#ifndef SERVER_TRADEOFF_VIEW_H
#define SERVER_TRADEOFF_VIEW_H

struct sga_buf;
struct slice;

/* CSV (RFC 4180): a line of names, a line for each row; what a row does not have is an empty field. */
void tradeoff_csv(struct slice tradeoff, struct sga_buf *out);
/* An SVG work-precision diagram: error across, seconds upwards, a curve for each method and arithmetic. */
void tradeoff_svg(struct slice tradeoff, struct sga_buf *out);

#endif
