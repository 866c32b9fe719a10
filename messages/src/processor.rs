//! Check that the processor has the instructions for which this program was built. `.cargo/config.toml` builds for the processor of the
//! build machine.
//!
//! The compiler may use these instructions in any function. The check is therefore written in assembly, with instructions that every
//! x86-64 processor has. It runs before `main`, or when a library that contains it is loaded.
#![allow(unsafe_code, reason = "only assembly controls which instructions are used")]

use std::arch::naked_asm;

/// Size of the buffer of a sentence [bytes].
const SENTENCE_SIZE: usize = 256;

/// A processor feature, and the CPUID bits that report it.
#[repr(C)]
struct Feature {
    leaf: u32,
    ebx: u32,
    ecx: u32,
    edx: u32,
    /// Length of the sentence; 0 if the program was not built for this feature.
    length: usize,
    sentence: [u8; SENTENCE_SIZE],
}

impl Feature {
    const fn built_for(sentence: &str, is: bool, leaf: u32, bits: [u32; 3]) -> Feature {
        let mut buffer = [0; SENTENCE_SIZE];
        buffer.split_at_mut(sentence.len()).0.copy_from_slice(sentence.as_bytes());
        let [ebx, ecx, edx] = bits;
        Feature { leaf, ebx, ecx, edx, length: if is { sentence.len() } else { 0 }, sentence: buffer }
    }
}

/// Name, CPUID leaf, register and bit of each feature.
macro_rules! features {
    (@ ebx $bit:literal) => { [1 << $bit, 0, 0] };
    (@ ecx $bit:literal) => { [0, 1 << $bit, 0] };
    (@ edx $bit:literal) => { [0, 0, 1 << $bit] };
    ($($name:literal, $leaf:literal, $register:ident $bit:literal;)*) => {
        [$(Feature::built_for(
            concat!("error: this program was built for processors with ", $name, ", but this processor lacks it; ",
                "`cargo build --release` on this machine builds a program for it, with the same results to the bit\n"),
            cfg!(target_feature = $name),
            $leaf,
            features!(@ $register $bit),
        )),*]
    };
}

/// Features that the compiler uses by itself. Older ones come first, because leaf 7 is undefined on a processor without AVX.
static FEATURES: [Feature; 31] = features! {
    "sse3", 1, ecx 0;
    "ssse3", 1, ecx 9;
    "cmpxchg16b", 1, ecx 13;
    "sse4.1", 1, ecx 19;
    "sse4.2", 1, ecx 20;
    "popcnt", 1, ecx 23;
    "sse4a", 0x8000_0001, ecx 6;
    "avx", 1, ecx 27; // the operating system saves the AVX registers
    "avx", 1, ecx 28;
    "f16c", 1, ecx 29;
    "fma", 1, ecx 12;
    "movbe", 1, ecx 22;
    "lzcnt", 0x8000_0001, ecx 5;
    "tbm", 0x8000_0001, ecx 21;
    "bmi1", 7, ebx 3;
    "avx2", 7, ebx 5;
    "bmi2", 7, ebx 8;
    "adx", 7, ebx 19;
    "gfni", 7, ecx 8;
    "avx512f", 7, ebx 16;
    "avx512dq", 7, ebx 17;
    "avx512ifma", 7, ebx 21;
    "avx512cd", 7, ebx 28;
    "avx512bw", 7, ebx 30;
    "avx512vl", 7, ebx 31;
    "avx512vbmi", 7, ecx 1;
    "avx512vbmi2", 7, ecx 6;
    "avx512vnni", 7, ecx 11;
    "avx512bitalg", 7, ecx 12;
    "avx512vpopcntdq", 7, ecx 14;
    "avx512fp16", 7, edx 23;
};

#[used]
#[unsafe(link_section = ".init_array.00001")]
static CHECK: extern "C" fn() = check;

/// Checks each feature of the table. At the first missing one it prints the sentence and ends the process.
#[unsafe(naked)]
extern "C" fn check() {
    naked_asm!(
        "push rbx", // CPUID overwrites it, and the caller expects it unchanged
        "lea r8, [rip + {features}]",
        "lea r9, [r8 + {size} * {count}]",
        "2:",
        "cmp r8, r9",
        "je 4f",
        "cmp qword ptr [r8 + {length}], 0",
        "je 3f",
        "mov eax, [r8]",
        "xor ecx, ecx",
        "cpuid",
        "not ebx",
        "not ecx",
        "not edx",
        "and ebx, [r8 + {ebx}]",
        "and ecx, [r8 + {ecx}]",
        "and edx, [r8 + {edx}]",
        "or ebx, ecx",
        "or ebx, edx",
        "jnz 5f",
        "3:",
        "add r8, {size}",
        "jmp 2b",
        "4:",
        "pop rbx",
        "ret",
        "5:", // write(2, sentence, length); exit_group(fault)
        "mov eax, 1",
        "mov edi, 2",
        "lea rsi, [r8 + {sentence}]",
        "mov rdx, [r8 + {length}]",
        "syscall",
        "mov eax, 231",
        "mov edi, {fault}",
        "syscall",
        "ud2",
        features = sym FEATURES,
        size = const size_of::<Feature>(),
        count = const FEATURES.len(),
        ebx = const std::mem::offset_of!(Feature, ebx),
        ecx = const std::mem::offset_of!(Feature, ecx),
        edx = const std::mem::offset_of!(Feature, edx),
        length = const std::mem::offset_of!(Feature, length),
        sentence = const std::mem::offset_of!(Feature, sentence),
        fault = const 4, // the exit code of `biped` for it
    );
}
