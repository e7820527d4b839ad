/* Inside this folder: the few x86-64 instructions that compiled tapes are made of.
 *
 * A growing run of bytes. Doubles stand in xmm registers and in slots; slots are addressed
 * from rbx, the two runs of results from rbp and r13, inputs from r14 (in code without calls, where the arguments came). Encodings: Intel 64 and IA-32 Architectures Software Developer's Manual,
 * volume 2 (legacy SSE2 forms, which every x86-64 has). */
#ifndef SGA_NUM_X64_H
#define SGA_NUM_X64_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct x64 {
    unsigned char *byte;
    size_t count, cap;
    bool leaf;                 /* no calls: everything stays in the registers that it came in */
};

/* Scalar double operations: the byte after F2 0F. */
enum x64_sd { X64_SQRT = 0x51, X64_ADD = 0x58, X64_MUL = 0x59, X64_SUB = 0x5C, X64_DIV = 0x5E };
/* On all bits of a register: the byte after 66 0F. */
enum x64_bits { X64_AND = 0x54, X64_XOR = 0x57 };
/* On two doubles at once: the byte after 66 0F. LOAD and STORE: at multiples of 16 bytes. LOW: to's and from's first;
 * HIGH: the second ones. */
enum x64_pair { X64_PAIR_LOAD = 0x28, X64_PAIR_STORE = 0x29, X64_PAIR_ADD = 0x58, X64_PAIR_MUL = 0x59, X64_PAIR_LOW = 0x14,
                X64_PAIR_HIGH = 0x15 };
enum x64_word { X64_RDI = 7, X64_RSI = 6, X64_RDX = 2, X64_RAX = 0 };

void x64_enter(struct x64 *c);             /* of f(double *slots, double *out, double *rest, const double *inputs) */
void x64_leave(struct x64 *c);
void x64_store_out(struct x64 *c, int reg, bool rest, int index);     /* to out[index] or rest[index] */
void x64_load(struct x64 *c, int reg, int slot);
void x64_store(struct x64 *c, int reg, int slot);
void x64_load_input(struct x64 *c, int reg, int index);               /* inputs[index] */
void x64_op_input(struct x64 *c, enum x64_sd op, int to, int index);
void x64_move(struct x64 *c, int to, int from);
void x64_op(struct x64 *c, enum x64_sd op, int to, int from);         /* to = to op from; sqrt: of from */
void x64_op_slot(struct x64 *c, enum x64_sd op, int to, int slot);
void x64_bitwise(struct x64 *c, enum x64_bits op, int to, int from);
void x64_constant(struct x64 *c, int to, uint64_t bits);              /* rax is lost */
void x64_load_at(struct x64 *c, int to, const double *address);       /* rax is lost */
void x64_pair(struct x64 *c, enum x64_pair op, int to, int from);
void x64_pair_out(struct x64 *c, enum x64_pair op, int reg, size_t index);       /* out[index], out[index + 1] */
void x64_pair_input(struct x64 *c, enum x64_pair op, int reg, size_t index);     /* inputs[index], ... */
/* If the bits of the one slot are those of the other: jump, to where x64_arrive is given what this returns. Else the other
 * is set to them. rax is lost. */
size_t x64_if_other(struct x64 *c, int slot, int other);
void x64_copy_input(struct x64 *c, int index, int slot);              /* inputs[index] to the slot; rax is lost */
void x64_word(struct x64 *c, enum x64_word reg, uint64_t value);
void x64_slot_address(struct x64 *c, enum x64_word reg, int slot);
/* Doubles that rsi and rdx point to, two at a time; those of rdx at multiples of 16 bytes. */
void x64_pair_load_rsi(struct x64 *c, int reg, int index);            /* rsi[index], rsi[index + 1] */
void x64_pair_mul_rdx(struct x64 *c, int reg, int index);
void x64_load_rsi(struct x64 *c, int reg, int index);
void x64_mul_rdx(struct x64 *c, int reg, int index);
/* Code that is called from code after it, by its offset. */
void x64_return(struct x64 *c);
void x64_call_back(struct x64 *c, size_t offset);
/* Leaves where the fourth argument is this number; returns what x64_arrive wants, at the place to go to. */
size_t x64_leave_if(struct x64 *c, int number);
void x64_arrive(struct x64 *c, size_t jump);
void x64_call(struct x64 *c, uint64_t address);                       /* all xmm and rax, ... are lost */

#endif
