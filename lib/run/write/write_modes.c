/* What the answer says of modes: the reductions that were reached, and which piece of the motion is in which. */
#include <string.h>

#include "buf.h"
#include "form.h"
#include "request.h"
#include "run_job.h"
#include "trajectory.h"
#include "write.h"

void answer_mode_values(const struct job *j, struct sga_json *w)
{
    sga_json_object(w);
    for (int k = 0; k < j->request->modes; k++) {
        const struct request_mode *m = j->request->mode + k;
        sga_json_key(w, m->name);
        sga_json_double(w, m->value[m->now]);
    }
    sga_json_end_object(w);
}

/* When the motion enters the mode of this place. */
static void write_entered(const struct job *j, int place, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    sga_json_key(w, "entered");
    sga_json_array(w);
    for (int i = 0; r && i < r->legs; i++)
        if (r->leg[i].mode == place && (!i || r->leg[i - 1].mode != place))
            sga_json_double(w, r->leg[i].t);
    sga_json_end_array(w);
}

void answer_write_modes(struct job *j, struct sga_json *w)
{
    if (!j->request->modes || j->place.depth)
        return;
    sga_json_key(w, "modes");
    sga_json_array(w);
    for (int k = 0; k < (j->modes.count ? j->modes.count : 1); k++) {
        sga_json_object(w);
        sga_json_key(w, "values");
        if (k)
            sga_json_raw(w, j->modes.values[k], strlen(j->modes.values[k]));
        else
            answer_mode_values(j, w);
        write_entered(j, k, w);
        sga_json_key(w, "reduction");
        if (k) {
            sga_json_raw(w, j->modes.entry[k], strlen(j->modes.entry[k]));
        } else {
            sga_json_object(w);
            answer_write_reduction(j, w);
            sga_json_end_object(w);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_pieces(const struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    const struct form_mechanical *m = j->request->mechanical;
    if (!r->legs)
        return;
    sga_json_key(w, "pieces");
    sga_json_array(w);
    for (int i = 0; i < r->legs; i++) {
        const struct traj_leg *l = r->leg + i;
        sga_json_object(w);
        sga_json_member_double(w, "t", l->t);
        if (j->request->modes) {
            sga_json_key(w, "mode");
            if (l->mode < j->modes.count)
                sga_json_raw(w, j->modes.values[l->mode], strlen(j->modes.values[l->mode]));
            else
                sga_json_null(w);
        }
        sga_json_member_string(w, "start", l->how);
        if (i)
            sga_json_member_double(w, "moved", l->moved);
        if (l->impulse && m) {
            sga_json_key(w, "impulse");
            sga_json_object(w);
            for (int k = 0; k < l->coordinates && k < m->coordinates; k++) {
                sga_json_key(w, j->request->store.symbol[m->coordinate[k]].name);
                sga_json_double(w, l->impulse[k]);
            }
            sga_json_end_object(w);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}
