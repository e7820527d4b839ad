/* FLINT's exact numbers and polynomials end with their block of code (arena.h): SGA_ENDS(fmpz_end) fmpz_t a = { 0 }, b = { 0 };
 * All zeros are an initialised 0 of the numbers and polynomials here but fmpq_t, { { 0, 1 } }; fmpz_poly_q_t, matrices and what is
 * modulo a prime have to be initialised before the next return. */
#ifndef SGA_BASE_FLINT_ENDS_H
#define SGA_BASE_FLINT_ENDS_H

#include <flint/fmpq.h>
#include <flint/fmpq_mat.h>
#include <flint/fmpq_poly.h>
#include <flint/fmpz_mat.h>
#include <flint/fmpz_poly_mat.h>
#include <flint/fmpz_poly_q.h>
#include <flint/nmod_mat.h>
#include <flint/nmod_poly.h>

#include "arena.h"

SGA_END_BY(fmpz_end, fmpz_t, fmpz_clear)
SGA_END_BY(fmpq_end, fmpq_t, fmpq_clear)
SGA_END_BY(fmpz_poly_end, fmpz_poly_t, fmpz_poly_clear)
SGA_END_BY(fmpq_poly_end, fmpq_poly_t, fmpq_poly_clear)
SGA_END_BY(fmpz_poly_q_end, fmpz_poly_q_t, fmpz_poly_q_clear)
SGA_END_BY(fmpz_mat_end, fmpz_mat_t, fmpz_mat_clear)
SGA_END_BY(fmpq_mat_end, fmpq_mat_t, fmpq_mat_clear)
SGA_END_BY(fmpz_poly_mat_end, fmpz_poly_mat_t, fmpz_poly_mat_clear)
SGA_END_BY(nmod_mat_end, nmod_mat_t, nmod_mat_clear)
SGA_END_BY(nmod_poly_end, nmod_poly_t, nmod_poly_clear)

#endif
