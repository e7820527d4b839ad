/* Lists in which what repeats is said once. */
#include <string.h>

#include "buf.h"
#include "families.h"
#include "job_texts.h"
#include "request.h"
#include "run_job.h"
#include "texts.h"
#include "warnings.h"
#include "write.h"

/* In one loop; fewer are as short as they are. */
enum { LEAST = 4 };

static void take_letter(bool taken[26], const char *name)
{
    if (*name >= 'a' && *name <= 'z' && (!name[1] || name[1] == '[' || name[1] == '\''))
        taken[*name - 'a'] = true;
}

void answer_fold(const struct job *j, struct sga_json *w, size_t start)
{
    const struct expr_store *st = &j->request->store;
    const struct expr_symbol *symbol = st->symbol;
    enum request_families how = j->request->families;
    struct families_how fold = { .longest = how == REQUEST_FAMILIES_AUTO ? SGA_MOST_FAMILIES : LEAST - 1, .least = LEAST };
    bool taken[26] = { false };
    start += w->out->data[start] == ',';
    if (how == REQUEST_FAMILIES_WHOLE)
        return;
    for (int i = 0; i < st->symbols; i++)
        take_letter(taken, symbol[i].name);
    for (int i = 0; j->texts && i < j->texts->names.count; i++)
        take_letter(taken, j->texts->names.name[i]);
    if (families_letters(taken, &fold.letters) && families_fold(w->out, start, &fold) && how == REQUEST_FAMILIES_AUTO)
        sga_limit_met(j->budget, SGA_LIMIT_FAMILIES);
}
