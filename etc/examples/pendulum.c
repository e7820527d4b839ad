/* A pendulum from C: how many constraints are hidden in its equations, and where it is after a second.
 *
 *     cc pendulum.c $(pkg-config --cflags --libs sga jansson) -o pendulum && ./pendulum */
#include <jansson.h>
#include <sga.h>
#include <stdio.h>
#include <string.h>

static const char *const request =
    "{\"system\": {\"form\": \"equations\", \"variables\": [\"x\", \"y\", \"lambda\"], \"parameters\": {\"g\": \"9.81\", \"L\": 1},"
    "  \"equations\": [\"x'' = -lambda*x\", \"y'' = -lambda*y - g\", \"x^2 + y^2 = L^2\"]},"
    " \"trajectory\": {\"start\": 0, \"stop\": 1, \"samples\": 2, \"initial\": {\"x\": 1, \"y\": 0, \"x'\": 0, \"y'\": 0}}}";

static void tell(const char *stage, double fraction)
{
    fprintf(stderr, "%s %.0f %%\n", stage, 100 * fraction);
}

static void progress(void *context, const char *stage, double fraction)
{
    if (*(const int *)context)
        tell(stage, fraction);
}

int main(int argc, char **argv)
{
    int talkative = argc > 1 && strcmp(argv[1], "-v") == 0;
    sga_options options = { .size = sizeof options, .seconds = 10, .progress = progress, .context = &talkative };
    sga_answer *a = sga_solve(request, strlen(request), &options);
    if (!sga_answer_ok(a)) {
        fprintf(stderr, "%s at %s: %s\n", sga_answer_code(a), sga_answer_pointer(a), sga_answer_detail(a));
        sga_answer_free(a);
        return 1;
    }
    json_t *result = json_loadb(sga_answer_text(a), sga_answer_length(a), 0, NULL);
    json_t *trajectory = json_object_get(result, "trajectory"), *last = json_array_get(json_object_get(trajectory, "rows"), 1);
    printf("constraints: %zu, index %lld\n", json_array_size(json_object_get(result, "constraints")),
           (long long)json_integer_value(json_object_get(json_object_get(result, "index"), "differentiation")));
    printf("x(1) = %.6f, y(1) = %.6f\n", json_number_value(json_array_get(last, 1)), json_number_value(json_array_get(last, 2)));
    json_decref(result);
    sga_answer_free(a);
    return 0;
}
