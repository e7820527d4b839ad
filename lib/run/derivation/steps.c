/* The list of steps, and its JSON. */
#include "steps.h"

#include <assert.h>
#include <string.h>

#include "arena.h"
#include "buf.h"

struct step *steps_add(struct steps *s, enum step_kind kind, int generation, const char *basis, const char *text)
{
    SGA_RESERVE_IN(s->mem, s->at, s->cap, s->count + 1);
    struct step *p = s->at + s->count++;
    *p = (struct step){ .kind = kind, .generation = generation, .text = sga_take_text(s->mem, text), .relation = "=", .before = s->dimension, .after = s->dimension,
                        .basis = basis };
    return p;
}

void steps_line(struct steps *s, struct step *p, expr_id left, expr_id right)
{
    SGA_RESERVE_IN(s->mem, p->line, p->line_cap, p->lines + 1);
    p->line[p->lines++] = (struct step_line){ left, right, NULL };
}

void steps_use(struct steps *s, struct step *p, int number)
{
    assert(number >= 1 && number <= (int)(p - s->at));
    for (int k = p->uses - 1; k >= 0; k--)
        if (p->use[k] == number)
            return;
    SGA_RESERVE_IN(s->mem, p->use, p->use_cap, p->uses + 1);
    p->use[p->uses++] = number;
}

void steps_term(struct steps *s, struct step *p, int number, expr_id factor)
{
    steps_use(s, p, number);
    SGA_RESERVE_IN(s->mem, p->term, p->term_cap, p->terms + 1);
    p->term[p->terms++] = (struct step_term){ number, factor };
}

/* One equation in the grammar or in LaTeX; false: it is too long. */
static bool put_line(struct derivation_sheet *s, const struct step *p, const struct step_line *l, bool latex, struct sga_buf *out)
{
    bool (*put)(struct derivation_sheet *, expr_id, struct sga_buf *) = latex ? derivation_sheet_latex : derivation_sheet_text;
    const char *relation = !latex || strcmp(p->relation, "!=") != 0 ? p->relation : "\\neq";
    if (!latex && l->text)
        sga_buf_puts(out, l->text);
    else if (!put(s, l->left, out))
        return false;
    sga_buf_printf(out, " %s ", relation);
    return put(s, l->right, out);
}

/* All equations of a step; null where one of them is too long, or there is none. */
static void write_lines(struct steps *s, const struct step *p, const char *member, bool latex, struct sga_json *w)
{
    SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
    bool ok = p->lines > 0;
    for (int k = 0; k < p->lines && ok; k++) {
        if (k)
            sga_buf_puts(&b, latex ? ",\\quad " : "; ");
        ok = put_line(s->sheet, p, p->line + k, latex, &b);
    }
    sga_json_key(w, member);
    if (ok)
        sga_json_string(w, b.data);
    else
        sga_json_null(w);
}

static void write_terms(struct steps *s, const struct step *p, struct sga_json *w)
{
    if (!p->terms)
        return;
    sga_json_key(w, "combination");
    sga_json_array(w);
    for (int k = 0; k < p->terms; k++) {
        SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
        sga_json_object(w);
        sga_json_member_int(w, "step", p->term[k].step);
        sga_json_key(w, "factor");
        if (derivation_sheet_text(s->sheet, p->term[k].factor, &b))
            sga_json_string(w, b.data);
        else
            sga_json_null(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_step(struct steps *s, int i, struct sga_json *w)
{
    static const char *const kind[] = {
#define X(symbol, text) text,
        STEP_KIND_TABLE(X)
#undef X
    };
    const struct step *p = s->at + i;
    sga_json_object(w);
    sga_json_member_int(w, "n", i + 1);
    sga_json_member_int(w, "generation", p->generation);
    sga_json_member_string(w, "kind", kind[p->kind]);
    sga_json_member_string(w, "text", p->text);
    write_lines(s, p, "latex", true, w);
    sga_json_key(w, "uses");
    sga_json_array(w);
    for (int k = 0; k < p->uses; k++)
        sga_json_int(w, p->use[k]);
    sga_json_end_array(w);
    write_terms(s, p, w);
    write_lines(s, p, "gives", false, w);
    sga_json_key(w, "dimension");
    sga_json_array(w);
    sga_json_int(w, p->before);
    sga_json_int(w, p->after);
    sga_json_end_array(w);
    sga_json_member_string(w, "basis", p->basis);
    sga_json_end_object(w);
}

void steps_write(struct steps *s, struct sga_json *w)
{
    sga_json_object(w);
    sga_json_key(w, "steps");
    sga_json_array(w);
    for (int i = 0; i < s->count; i++)
        write_step(s, i, w);
    sga_json_end_array(w);
    sga_json_end_object(w);
}
