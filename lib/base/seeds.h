/* Seeds of random numbers: one list, so that an answer is the same each time it is asked for, and two searches that are to be independent
 * do not draw the same. Any other values would do; a test that rests on one of these says so. */
#ifndef SGA_BASE_SEEDS_H
#define SGA_BASE_SEEDS_H

/*    name             value      what is drawn */
#define SGA_SEED_TABLE(X) \
    X(REDUCTION,       1,        "points of the constraint sets of a system, on which its reduction decides") \
    X(MOTION,          2,        "the same where a motion has a reduction of its own") \
    X(CHART,           31,       "the same for other pivots along a motion") \
    X(FIBRE,           3,        "the same for the kinematics of constraints in velocities") \
    X(WITNESS,         78,       "points of the witness: none of the reduction's") \
    X(WITNESS_DRAWS,   1,        "directions in which the witness asks for tangency") \
    X(SIGNS,           77,       "signs of symbolic parameters for which there are points") \
    X(COMPONENTS,      41,       "far starts, for other components") \
    X(BESIDE,          43,       "points beside one, that tell whether two runs are on one component") \
    X(DOMAIN,          71,       "points modulo a prime where divisors do not vanish") \
    X(BLOCK,           4,        "values that show a block's determinant not to be 0") \
    X(CELLS,           11,       "starts beyond the sides of switches") \
    X(MOTION_START,    3,        "a start of a motion where none is given") \
    X(COMPONENT_START, 5,        "a start on the component of a guess") \
    X(LARGE_START,     17,       "shifts of a start that steps do not leave") \
    X(ALL_GIVEN,       23,       "starts at which all given equations hold") \
    X(REDUNDANT,       7,        "points where equations that were called redundant are looked at") \
    X(POLE,            12345,    "directions in which a pole is approached") \
    X(DROPS,           7,        "points where the rank of velocities' constraints drops") \
    X(DROPS_AGAIN,     11,       "the same, from other starts") \
    X(GRAM_DIRECTIONS, 12345,    "directions in which exponents are extreme") \
    X(GRAM_SAMPLES,    20261122, "values that may show a polynomial to change its sign") \
    X(EQUILIBRIA,      29,       "starts of a search for equilibria") \
    X(FIT,             31,       "further guesses of a fit") \
    X(SYM_SOLVE,       20250901, "points of the linear equations for symmetries") \
    X(SYM_COMMUTATORS, 20250930, "points at which commutators are compared") \
    X(SYM_REAL,        20261121, "real points of those equations")

enum sga_seed {
#define X(name, value, what) SGA_SEED_##name = value,
    SGA_SEED_TABLE(X)
#undef X
};

#endif
