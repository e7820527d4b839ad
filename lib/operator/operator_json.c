/* Operators as JSON. */
#include "operator_json.h"

#include "buf.h"
#include "text.h"

void op_json_ratio(struct sga_json *w, const fmpz_poly_q_t a, const char *time)
{
    struct sga_buf text = { 0 };
    op_text_ratio(&text, a, time);
    sga_json_string(w, text.data);
    sga_buf_free(&text);
}

void op_json_ratios(struct sga_json *w, const struct ratio_matrix *m, const char *time)
{
    sga_json_array(w);
    for (int i = 0; i < m->rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < m->cols; k++)
            op_json_ratio(w, ratio_at(m, i, k), time);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

void op_json_ore(struct sga_json *w, const struct ore *x, const char *time)
{
    sga_json_array(w);
    for (int k = 0; k < x->len; k++)
        op_json_ratio(w, x->a + k, time);
    sga_json_end_array(w);
}

void op_json_ores(struct sga_json *w, const struct ore_matrix *m, const char *time)
{
    sga_json_array(w);
    for (int i = 0; i < m->rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < m->cols; k++)
            op_json_ore(w, ore_at(m, i, k), time);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}
