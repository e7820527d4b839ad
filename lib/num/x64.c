/* Encoding of single instructions. */
#include "x64.h"

#include <assert.h>
#include <string.h>

#include "mem.h"

/* rbx (rdi in leaves) points here, so that more slots are within one signed byte of it. */
enum { BIAS = 16 * 8, RCX = 1, RBX = 3, RBP = 5, R13 = 13, R14 = 14 };

static void put(struct x64 *c, const void *bytes, size_t n)
{
    SGA_RESERVE(c->byte, c->cap, c->count + n);
    memcpy(c->byte + c->count, bytes, n);
    c->count += n;
}

static void put1(struct x64 *c, unsigned b)
{
    unsigned char byte = (unsigned char)b;
    put(c, &byte, 1);
}

static void put_opcode(struct x64 *c, unsigned prefix, unsigned rex, unsigned opcode)
{
    if (prefix)
        put1(c, prefix);
    if (rex)
        put1(c, 0x40 | rex);
    put1(c, 0x0F);
    put1(c, opcode);
}

/* op reg, reg */
static void registers(struct x64 *c, unsigned prefix, unsigned opcode, int to, int from)
{
    put_opcode(c, prefix, (unsigned)(to >> 3 << 2 | from >> 3), opcode);
    put1(c, 0xC0 | (unsigned)((to & 7) << 3 | (from & 7)));
}

/* The operand [base + d], of any base but rsp and r12; reg is the other one. */
static void memory_operand(struct x64 *c, int reg, int base, int32_t d)
{
    if (d >= -128 && d < 128) {
        put1(c, 0x40 | (unsigned)((reg & 7) << 3 | (base & 7)));
        put1(c, (unsigned)d & 0xFF);
    } else {
        put1(c, 0x80 | (unsigned)((reg & 7) << 3 | (base & 7)));
        put(c, &d, sizeof d);
    }
}

static void with_slot(struct x64 *c, unsigned prefix, unsigned opcode, int reg, int slot)
{
    put_opcode(c, prefix, (unsigned)(reg >> 3 << 2), opcode);
    memory_operand(c, reg, c->leaf ? X64_RDI : RBX, 8 * slot - BIAS);
}

static void with_input(struct x64 *c, unsigned opcode, int reg, int index)
{
    int base = c->leaf ? RCX : R14;
    put_opcode(c, 0xF2, (unsigned)(reg >> 3 << 2 | base >> 3), opcode);
    memory_operand(c, reg, base, 8 * index);
}

void x64_store_out(struct x64 *c, int reg, bool rest, int index)
{
    int base = c->leaf ? (rest ? X64_RDX : X64_RSI) : rest ? R13 : RBP;
    put_opcode(c, 0xF2, (unsigned)(reg >> 3 << 2 | base >> 3), 0x11);
    memory_operand(c, reg, base, 8 * index);
}

/* Five pushes leave the stack aligned for calls. */
void x64_enter(struct x64 *c)
{
    static const unsigned char leaf[] = { 0x48, 0x83, 0xEF, 0x100 - BIAS };    /* sub rdi, -BIAS */
    static const unsigned char code[] = { 0x53, 0x55, 0x41, 0x55, 0x41, 0x56, 0x50,   /* push rbx; rbp; r13; r14; rax */
                                          0x48, 0x8D, 0x9F, BIAS, 0, 0, 0,     /* lea rbx, [rdi + BIAS] */
                                          0x48, 0x89, 0xF5, 0x49, 0x89, 0xD5,  /* mov rbp, rsi; mov r13, rdx */
                                          0x49, 0x89, 0xCE };                  /* mov r14, rcx */
    if (c->leaf)
        put(c, leaf, sizeof leaf);
    else
        put(c, code, sizeof code);
}

void x64_leave(struct x64 *c)
{
    if (c->leaf)
        put1(c, 0xC3);
    else
        put(c, "\x59\x41\x5E\x41\x5D\x5D\x5B\xC3", 8);       /* pop rcx; r14; r13; rbp; rbx; ret */
}

void x64_load(struct x64 *c, int reg, int slot) { with_slot(c, 0xF2, 0x10, reg, slot); }
void x64_load_input(struct x64 *c, int reg, int index) { with_input(c, 0x10, reg, index); }
void x64_op_input(struct x64 *c, enum x64_sd op, int to, int index) { with_input(c, op, to, index); }
void x64_store(struct x64 *c, int reg, int slot) { with_slot(c, 0xF2, 0x11, reg, slot); }
void x64_move(struct x64 *c, int to, int from) { registers(c, 0, 0x28, to, from); }     /* movaps */
void x64_op(struct x64 *c, enum x64_sd op, int to, int from) { registers(c, 0xF2, op, to, from); }
void x64_op_slot(struct x64 *c, enum x64_sd op, int to, int slot) { with_slot(c, 0xF2, op, to, slot); }
void x64_bitwise(struct x64 *c, enum x64_bits op, int to, int from) { registers(c, 0x66, op, to, from); }

void x64_pair(struct x64 *c, enum x64_pair op, int to, int from) { registers(c, 0x66, op, to, from); }

static void pair_at(struct x64 *c, enum x64_pair op, int reg, int base, size_t index)
{
    put_opcode(c, 0x66, (unsigned)(reg >> 3 << 2 | base >> 3), op);
    memory_operand(c, reg, base, (int32_t)(8 * index));
}

void x64_pair_out(struct x64 *c, enum x64_pair op, int reg, size_t index) { pair_at(c, op, reg, c->leaf ? X64_RSI : RBP, index); }
void x64_pair_input(struct x64 *c, enum x64_pair op, int reg, size_t index) { pair_at(c, op, reg, c->leaf ? RCX : R14, index); }

/* mov rax, slot (opcode 8B), cmp rax, slot (3B), mov slot, rax (89) */
static void word_slot(struct x64 *c, unsigned opcode, int slot)
{
    put1(c, 0x48);
    put1(c, opcode);
    memory_operand(c, X64_RAX, c->leaf ? X64_RDI : RBX, 8 * slot - BIAS);
}

void x64_copy_input(struct x64 *c, int index, int slot)
{
    int base = c->leaf ? RCX : R14;
    put1(c, 0x48 | (unsigned)(base >> 3));
    put1(c, 0x8B);
    memory_operand(c, X64_RAX, base, 8 * index);
    word_slot(c, 0x89, slot);
}

size_t x64_if_other(struct x64 *c, int slot, int other)
{
    word_slot(c, 0x8B, slot);
    word_slot(c, 0x3B, other);
    put(c, "\x0F\x84\0\0\0\0", 6);      /* je rel32 */
    size_t jump = c->count;
    word_slot(c, 0x89, other);
    return jump;
}

static void with_pointer(struct x64 *c, unsigned prefix, unsigned opcode, int reg, enum x64_word base, int index)
{
    put_opcode(c, prefix, (unsigned)(reg >> 3 << 2), opcode);
    memory_operand(c, reg, base, 8 * index);
}

void x64_pair_load_rsi(struct x64 *c, int reg, int index) { with_pointer(c, 0x66, 0x10, reg, X64_RSI, index); }     /* movupd */
void x64_pair_mul_rdx(struct x64 *c, int reg, int index) { with_pointer(c, 0x66, X64_MUL, reg, X64_RDX, index); }
void x64_load_rsi(struct x64 *c, int reg, int index) { with_pointer(c, 0xF2, 0x10, reg, X64_RSI, index); }
void x64_mul_rdx(struct x64 *c, int reg, int index) { with_pointer(c, 0xF2, X64_MUL, reg, X64_RDX, index); }
void x64_return(struct x64 *c) { put1(c, 0xC3); }

void x64_call_back(struct x64 *c, size_t offset)
{
    assert(offset <= c->count);
    int32_t distance = (int32_t)((ptrdiff_t)offset - (ptrdiff_t)(c->count + 5));
    put1(c, 0xE8);
    put(c, &distance, sizeof distance);
}

size_t x64_leave_if(struct x64 *c, int number)
{
    assert(number >= 0);
    unsigned char code[] = { 0x49, 0x81, 0xFE, 0, 0, 0, 0, 0x0F, 0x84, 0, 0, 0, 0 };   /* cmp r14, imm32; je rel32 */
    memcpy(code + 3, &number, sizeof number);
    put(c, code, sizeof code);
    return c->count;
}

void x64_arrive(struct x64 *c, size_t jump)
{
    assert(jump <= c->count && jump >= sizeof(int32_t));
    int32_t distance = (int32_t)(c->count - jump);
    memcpy(c->byte + jump - sizeof distance, &distance, sizeof distance);
}

void x64_word(struct x64 *c, enum x64_word reg, uint64_t value)
{
    put1(c, 0x48);               /* mov reg, imm64 */
    put1(c, 0xB8 | (unsigned)reg);
    put(c, &value, sizeof value);
}

void x64_constant(struct x64 *c, int to, uint64_t bits)
{
    x64_word(c, X64_RAX, bits);
    put_opcode(c, 0x66, (unsigned)(8 | to >> 3 << 2), 0x6E);                   /* movq to, rax */
    put1(c, 0xC0 | (unsigned)((to & 7) << 3));
}

void x64_load_at(struct x64 *c, int to, const double *address)
{
    x64_word(c, X64_RAX, (uintptr_t)address);
    put_opcode(c, 0xF2, (unsigned)(to >> 3 << 2), 0x10);                       /* movsd to, [rax] */
    put1(c, (unsigned)((to & 7) << 3));
}

void x64_slot_address(struct x64 *c, enum x64_word reg, int slot)
{
    put1(c, 0x48);               /* lea reg, [rbx + ...] */
    put1(c, 0x8D);
    memory_operand(c, reg, RBX, 8 * slot - BIAS);
}

void x64_call(struct x64 *c, uint64_t address)
{
    x64_word(c, X64_RAX, address);
    put(c, "\xFF\xD0", 2);       /* call rax */
}
