//! From the C of `wasm2c` to a program that CBMC decides: one harness, what it calls, and a memory of small arrays.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The name of the module in the C.
pub(super) const MODULE: &str = "harness";

const RUNTIME: &str = include_str!("runtime.h");
const TYPES: &str = "\
typedef unsigned char u8; typedef signed char s8; typedef unsigned short u16; typedef signed short s16;
typedef unsigned int u32; typedef signed int s32; typedef unsigned long long u64; typedef signed long long s64;
typedef float f32; typedef double f64; typedef struct { int unused; } w2c_harness;
";

/// Ends the path with a failure.
const FAILED: &str = "\
static void failed(void) { __CPROVER_assert(0, \"a harness fails\"); __CPROVER_assume(0); }
";

/// Bytes of one array of the memory.
const ARRAY: usize = 64;
/// Bytes of memory beyond the data: the heap of the harnesses, and what the linker aligns.
const HEAP: usize = (16 << 10) + 1024;

/// Parts of names of functions that only report a panic. A call of one is a failure.
const PANICS: [&str; 7] = [
    "panicking",
    "rust_begin_unwind",
    "unwrap_failed",
    "expect_failed",
    "handle_alloc_error",
    "handle_error",
    "slice_index_fail",
];

/// The C of a whole module, by its parts.
#[derive(Debug)]
pub(super) struct Module<'a> {
    functions: BTreeMap<&'a str, &'a str>,
    stack_top: usize,
    /// Address and bytes of each data segment.
    data: Vec<(usize, Vec<u8>)>,
}

impl<'a> Module<'a> {
    /// Reads the C of `wasm2c`. `None` when it has another form than the one of version 1.0.36.
    pub(super) fn read(source: &'a str) -> Option<Self> {
        let stack_top = number_after(source, "w2c_0x5F_stack_pointer = ")?;
        let mut data = Vec::new();
        for (at, _) in source.match_indices("LOAD_DATA(instance->w2c_memory, ") {
            let call = &source[at..source[at..].find(';')? + at];
            let mut parts = call.split(", ").skip(1);
            let address = parts.next()?.trim_end_matches('u').parse().ok()?;
            let array = &source[source.find(&format!("static const u8 {}[] = {{", parts.next()?))?..];
            let bytes = array[array.find('{')? + 1..array.find("};")?].split(',');
            let byte = |text: &str| u8::from_str_radix(text.trim().strip_prefix("0x")?, 16).ok();
            data.push((address, bytes.filter_map(byte).collect()));
        }
        let functions: BTreeMap<_, _> = definitions(source).collect();
        (!functions.is_empty()).then_some(Self { functions, stack_top, data })
    }

    /// The program of one harness. `None` when the module has no such harness.
    pub(super) fn program(&self, harness: &str) -> Option<String> {
        let start = format!("w2c_{MODULE}_{harness}");
        let reached = self.reached(&start)?;
        let top = format!("#define STACK_TOP {}u\n", self.stack_top);
        let mut program = TYPES.to_string() + FAILED + &top + &self.memory() + RUNTIME;
        for name in &reached {
            let head = self.functions[name].split(" {\n").next()?;
            writeln!(program, "{head};").ok()?;
        }
        for name in &reached {
            let definition = self.functions[name];
            if is_panic(name) {
                let head = definition.split(" {\n").next()?;
                let value =
                    if head.starts_with("void") || head.starts_with("static void") { "" } else { " 0" };
                writeln!(program, "{head} {{ failed(); return{value}; }}").ok()?;
            } else {
                program += &simplified(definition);
            }
        }
        writeln!(program, "int main(void) {{ stack_pointer = STACK_TOP; {start}(0); return 0; }}").ok()?;
        Some(program)
    }

    /// The functions that the start calls, directly or not.
    fn reached(&self, start: &str) -> Option<BTreeSet<&'a str>> {
        let mut reached = BTreeSet::new();
        let mut open = vec![*self.functions.get_key_value(start)?.0];
        while let Some(name) = open.pop() {
            if reached.insert(name) && !is_panic(name) {
                let body = self.functions[name];
                open.extend(self.functions.keys().filter(|callee| calls(body, callee)));
            }
        }
        Some(reached)
    }

    /// Arrays of [`ARRAY`] bytes, and the functions that find the one of a word.
    fn memory(&self) -> String {
        let end = self.data.iter().map(|(at, bytes)| at + bytes.len()).max().unwrap_or(0).max(self.stack_top);
        let mut bytes = vec![0_u8; (end + HEAP).next_multiple_of(ARRAY)];
        for (at, segment) in &self.data {
            bytes[*at..at + segment.len()].copy_from_slice(segment);
        }
        let mut text = String::new();
        let arrays = bytes.chunks(ARRAY);
        let count = arrays.len();
        for (number, array) in arrays.enumerate() {
            let words = array
                .chunks(4)
                .map(|word| word.iter().rev().fold(0_u32, |sum, byte| sum << 8 | u32::from(*byte)));
            let words: Vec<String> = words.map(|word| format!("{word}u")).collect();
            let _ = writeln!(text, "static u32 m{number}[{}] = {{{}}};", ARRAY / 4, words.join(","));
        }
        let find = |leaf: &dyn Fn(usize) -> String| chosen(0, count, leaf);
        let load = find(&|number| format!("return m{number}[i];"));
        let store = find(&|number| format!("m{number}[i] = v;"));
        let words = ARRAY / 4;
        let split = format!("if (w >= {}u) failed(); u32 n = w / {words}, i = w % {words};", count * words);
        let _ = writeln!(text, "static u32 load_word(u32 w) {{ {split} {load} }}");
        let _ = writeln!(text, "static void store_word(u32 w, u32 v) {{ {split} {store} }}");
        text
    }
}

/// A binary tree of conditions that chooses the array of number `n`.
fn chosen(low: usize, high: usize, leaf: &dyn Fn(usize) -> String) -> String {
    if high - low == 1 {
        return leaf(low);
    }
    let middle = low.midpoint(high);
    format!(
        "if (n < {middle}u) {{ {} }} else {{ {} }}",
        chosen(low, middle, leaf),
        chosen(middle, high, leaf)
    )
}

fn is_panic(name: &str) -> bool {
    PANICS.iter().any(|part| name.contains(part))
}

fn calls(body: &str, callee: &str) -> bool {
    body.match_indices(callee).any(|(at, _)| {
        let (before, after) = (&body[..at], &body[at + callee.len()..]);
        let whole = !before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        whole && after.starts_with("(instance")
    })
}

/// The functions of the module: name and definition.
fn definitions(source: &str) -> impl Iterator<Item = (&str, &str)> {
    let instance = format!("(w2c_{MODULE}* instance");
    source.match_indices(") {\n").filter_map(move |(at, _)| {
        let begin = source[..at].rfind('\n')? + 1;
        let head = &source[begin..at];
        let name = head[..head.find(&instance)?].rsplit([' ', '*']).next()?;
        let end = at + source[at..].find("\n}\n")? + 3;
        (!head.starts_with(' ')).then(|| (name, &source[begin..end]))
    })
}

/// The definition without the instance of the module, and with a failure for each call through a table.
///
/// A conditional jump back to the head of a loop becomes a jump over an unconditional one. CBMC 6.6 loses the path
/// that leaves such a loop at its end, if a later round of the loop leaves it by a jump farther ahead: it steps over
/// instructions to which no jump leads, and the path waits at one of them (`symex_goto`, "skip dead instructions").
/// The assignment between the jumps keeps CBMC from joining them again.
fn simplified(definition: &str) -> String {
    let plain = definition
        .replace("instance->w2c_0x5F_stack_pointer = var_i0;", "set_stack(var_i0);")
        .replace("instance->w2c_0x5F_stack_pointer", "stack_pointer")
        .replace("instance->w2c_checker_instance", "0")
        .replace("&instance->w2c_memory", "0")
        .replace("FUNC_PROLOGUE;", "")
        .replace("FUNC_EPILOGUE;", "");
    let mut text = String::new();
    for (number, line) in plain.lines().enumerate() {
        if let Some((before, _)) = line.split_once("CALL_INDIRECT(") {
            text += &format!("{before}indirect_call();");
        } else if let Some((condition, label)) = jump_back(line) {
            text += &format!(
                "if (!({condition})) {{goto passed_{number};}} loops = 1; goto {label}; passed_{number}:;"
            );
        } else {
            text += line;
        }
        text.push('\n');
    }
    text
}

/// Condition and label of a conditional jump to the head of a loop.
fn jump_back(line: &str) -> Option<(&str, &str)> {
    let (condition, jump) = line.trim().strip_prefix("if (")?.rsplit_once(") {goto ")?;
    let label = jump.strip_suffix(";}")?;
    label.starts_with("var_L").then_some((condition, label))
}

fn number_after(source: &str, mark: &str) -> Option<usize> {
    let text = &source[source.find(mark)? + mark.len()..];
    text[..text.find(|c: char| !c.is_ascii_digit())?].parse().ok()
}
