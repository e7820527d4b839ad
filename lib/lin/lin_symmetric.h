/* Eigenvalues and eigenvectors of small symmetric matrices. */
#ifndef SGA_LIN_SYMMETRIC_H
#define SGA_LIN_SYMMETRIC_H

/* A (n x n, symmetric, overwritten) = sum_k value_k v_k v_k^T, v_k orthonormal in row k of vector. By Jacobi's rotations:
 * small eigenvalues keep an absolute accuracy of some roundings of the largest. Cost some 10 n^3. */
void lin_symmetric(int n, double *A, double *value, double *vector);

#endif
