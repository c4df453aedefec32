/* What the translated harnesses stand on: numbers, memory, inputs and failures, for CBMC.
 *
 * The translator puts the memory before this file: `load_word` and `store_word` read and write 32 bits at a word's
 * number, and an access beyond the memory fails. The memory is many small arrays, because CBMC handles an array of
 * few elements as single variables. */

#define INFINITY (1.0f / 0.0f)
#define NAN (0.0f / 0.0f)

static u32 stack_pointer;
/* Written where a loop begins another round. */
static u32 loops;

/* An input that the trace of a counterexample shows. */
u32 nondet_u32(void);
u32 input_value;
static u32 w2c_checker_any(int instance) {
  input_value = nondet_u32();
  return input_value;
}
#define w2c_checker_assume(instance, condition) __CPROVER_assume(condition)

/* The stack lies below its top, and grows down to address zero. */
static void set_stack(u32 to) {
  __CPROVER_assert(to <= STACK_TOP, "the stack is large enough");
  stack_pointer = to;
}
#define w2c_checker_fail(instance) failed()
#define UNREACHABLE failed()
static u32 indirect_call(void) {
  __CPROVER_assert(0, "a call through a table");
  __CPROVER_assume(0);
  return 0;
}

static u32 load8(u32 a) { return (load_word(a >> 2) >> (8 * (a & 3))) & 255u; }
static u32 load16(u32 a) {
  if ((a & 3) != 3) return (load_word(a >> 2) >> (8 * (a & 3))) & 65535u;
  return load8(a) | load8(a + 1) << 8;
}
static u32 load32(u32 a) {
  if ((a & 3) == 0) return load_word(a >> 2);
  u32 s = 8 * (a & 3);
  return load_word(a >> 2) >> s | load_word((a >> 2) + 1) << (32 - s);
}
static u64 load64(u32 a) { return (u64)load32(a) | (u64)load32(a + 4) << 32; }

static void store8(u32 a, u32 v) {
  u32 s = 8 * (a & 3);
  store_word(a >> 2, (load_word(a >> 2) & ~(255u << s)) | ((v & 255u) << s));
}
static void store16(u32 a, u32 v) {
  u32 s = 8 * (a & 3);
  if ((a & 3) != 3) {
    store_word(a >> 2, (load_word(a >> 2) & ~(65535u << s)) | ((v & 65535u) << s));
  } else {
    store8(a, v);
    store8(a + 1, v >> 8);
  }
}
static void store32(u32 a, u32 v) {
  if ((a & 3) == 0) {
    store_word(a >> 2, v);
  } else {
    store16(a, v);
    store16(a + 2, v >> 16);
  }
}
static void store64(u32 a, u64 v) {
  store32(a, (u32)v);
  store32(a + 4, (u32)(v >> 32));
}

#define i32_load(m, a) load32((u32)(a))
#define i64_load(m, a) load64((u32)(a))
#define i32_load8_s(m, a) ((u32)(s32)(s8)load8((u32)(a)))
#define i64_load8_s(m, a) ((u64)(s64)(s8)load8((u32)(a)))
#define i32_load8_u(m, a) load8((u32)(a))
#define i64_load8_u(m, a) ((u64)load8((u32)(a)))
#define i32_load16_s(m, a) ((u32)(s32)(s16)load16((u32)(a)))
#define i64_load16_s(m, a) ((u64)(s64)(s16)load16((u32)(a)))
#define i32_load16_u(m, a) load16((u32)(a))
#define i64_load16_u(m, a) ((u64)load16((u32)(a)))
#define i64_load32_s(m, a) ((u64)(s64)(s32)load32((u32)(a)))
#define i64_load32_u(m, a) ((u64)load32((u32)(a)))
#define i32_store(m, a, v) store32((u32)(a), (u32)(v))
#define i64_store(m, a, v) store64((u32)(a), (u64)(v))
#define i32_store8(m, a, v) store8((u32)(a), (u32)(v))
#define i32_store16(m, a, v) store16((u32)(a), (u32)(v))
#define i64_store8(m, a, v) store8((u32)(a), (u32)(v))
#define i64_store16(m, a, v) store16((u32)(a), (u32)(v))
#define i64_store32(m, a, v) store32((u32)(a), (u32)(v))

static f32 f32_reinterpret_i32(u32 v) { union { u32 i; f32 f; } c; c.i = v; return c.f; }
static u32 i32_reinterpret_f32(f32 v) { union { u32 i; f32 f; } c; c.f = v; return c.i; }
static f64 f64_reinterpret_i64(u64 v) { union { u64 i; f64 f; } c; c.i = v; return c.f; }
static u64 i64_reinterpret_f64(f64 v) { union { u64 i; f64 f; } c; c.f = v; return c.i; }
#define f32_load(m, a) f32_reinterpret_i32(load32((u32)(a)))
#define f64_load(m, a) f64_reinterpret_i64(load64((u32)(a)))
#define f32_store(m, a, v) store32((u32)(a), i32_reinterpret_f32(v))
#define f64_store(m, a, v) store64((u32)(a), i64_reinterpret_f64(v))

static void memory_copy(int m, int n, u32 to, u32 from, u32 count) {
  if (((to | from | count) & 3) == 0) {
    if (to <= from) {
      for (u32 i = 0; i < count; i += 4) store_word((to + i) >> 2, load_word((from + i) >> 2));
    } else {
      for (u32 i = count; i > 0; i -= 4) store_word((to + i - 4) >> 2, load_word((from + i - 4) >> 2));
    }
  } else if (to <= from) {
    for (u32 i = 0; i < count; i++) store8(to + i, load8(from + i));
  } else {
    for (u32 i = count; i > 0; i--) store8(to + i - 1, load8(from + i - 1));
  }
}
static void memory_fill(int m, u32 to, u32 value, u32 count) {
  for (u32 i = 0; i < count; i++) store8(to + i, value);
}

static u32 division_by_zero(void) { failed(); return 0; }
#define DIV_U(a, b) ((b) == 0 ? division_by_zero() : (a) / (b))
#define REM_U(a, b) ((b) == 0 ? division_by_zero() : (a) % (b))
static u32 I32_DIV_S(u32 a, u32 b) {
  if (b == 0 || (a == 0x80000000u && b == 0xffffffffu)) failed();
  return (u32)((s32)a / (s32)b);
}
static u32 I32_REM_S(u32 a, u32 b) {
  if (b == 0) failed();
  return b == 0xffffffffu ? 0 : (u32)((s32)a % (s32)b);
}
static u64 I64_DIV_S(u64 a, u64 b) {
  if (b == 0 || (a == 0x8000000000000000ull && b == 0xffffffffffffffffull)) failed();
  return (u64)((s64)a / (s64)b);
}
static u64 I64_REM_S(u64 a, u64 b) {
  if (b == 0) failed();
  return b == 0xffffffffffffffffull ? 0 : (u64)((s64)a % (s64)b);
}
#define I32_CLZ(v) ((v) ? __builtin_clz(v) : 32)
#define I32_CTZ(v) ((v) ? __builtin_ctz(v) : 32)
#define I64_CLZ(v) ((v) ? __builtin_clzll(v) : 64)
#define I64_CTZ(v) ((v) ? __builtin_ctzll(v) : 64)
#define I32_POPCNT(v) __builtin_popcount(v)
#define I64_POPCNT(v) __builtin_popcountll(v)
#define I32_ROTL(x, y) (((x) << ((y) & 31)) | ((x) >> ((32 - ((y) & 31)) & 31)))
#define I64_ROTL(x, y) (((x) << ((y) & 63)) | ((x) >> ((64 - ((y) & 63)) & 63)))
#define I32_ROTR(x, y) (((x) >> ((y) & 31)) | ((x) << ((32 - ((y) & 31)) & 31)))
#define I64_ROTR(x, y) (((x) >> ((y) & 63)) | ((x) << ((64 - ((y) & 63)) & 63)))
#define LIKELY(x) (x)
#define UNLIKELY(x) (x)

static f64 wasm_quiet(f64 x) { return x; }
static f32 wasm_quietf(f32 x) { return x; }
static f64 wasm_fabs(f64 x) { return f64_reinterpret_i64(i64_reinterpret_f64(x) & 0x7fffffffffffffffull); }
static f64 FMAX(f64 x, f64 y) {
  if (x != x || y != y) return x + y;
  return x == y ? (i64_reinterpret_f64(x) >> 63 ? y : x) : x > y ? x : y;
}
static f64 FMIN(f64 x, f64 y) {
  if (x != x || y != y) return x + y;
  return x == y ? (i64_reinterpret_f64(x) >> 63 ? x : y) : x < y ? x : y;
}
static f64 copysign(f64 x, f64 y) {
  u64 sign = 1ull << 63;
  return f64_reinterpret_i64((i64_reinterpret_f64(x) & ~sign) | (i64_reinterpret_f64(y) & sign));
}
static u32 I32_TRUNC_SAT_S_F64(f64 x) {
  if (x != x) return 0;
  if (!(x > -2147483649.0)) return 0x80000000u;
  return x < 2147483648.0 ? (u32)(s32)x : 0x7fffffffu;
}
static u64 I64_TRUNC_SAT_S_F64(f64 x) {
  if (x != x) return 0;
  if (!(x >= -9223372036854775808.0)) return 1ull << 63;
  return x < 9223372036854775808.0 ? (u64)(s64)x : ~(1ull << 63);
}
