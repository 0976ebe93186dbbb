//! The processor's tile unit: eight registers of 16 rows of 64 bytes, and TDPBF16PS.
//!
//! The system saves the registers only for processes that asked it to, and a thread uses them only
//! under a configuration of their shapes. Between two `asm!` blocks nothing lies in them that is
//! wanted later; only the configuration stays.

#![allow(unsafe_code)]

use std::arch::asm;
use std::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};
use std::cell::Cell;
use std::marker::PhantomData;
use std::sync::OnceLock;

use super::block::{Block, Tile, Tiles};

/// Bytes of a row of a tile.
const ROW: usize = 64;

/// Whether this process may use the tiles of this processor. Asked for once.
pub(super) fn permitted() -> bool {
    static PERMITTED: OnceLock<bool> = OnceLock::new();
    *PERMITTED.get_or_init(|| built_in() && saved_by_the_system() && permission().is_ok())
}

/// The processor has tiles of our shape and multiplies bf16 in them (CPUID leaves 7 and 1Dh).
fn built_in() -> bool {
    const BF16: u32 = 1 << 22;
    const TILE: u32 = 1 << 24;
    if __cpuid(0).eax < 0x1d || __cpuid_count(7, 0).edx & (BF16 | TILE) != BF16 | TILE {
        return false;
    }
    let palette = __cpuid_count(0x1d, 1);
    let (registers, row_bytes, rows) = (palette.ebx >> 16, palette.ebx & 0xffff, palette.ecx);
    registers >= 8 && row_bytes == ROW as u32 && rows & 0xffff == 16
}

/// The system switches the tiles' state from one thread to the next (bits 17 and 18 of XCR0).
fn saved_by_the_system() -> bool {
    const OSXSAVE: u32 = 1 << 27;
    const TILES: u64 = 3 << 17;
    if __cpuid(1).ecx & OSXSAVE == 0 {
        return false;
    }
    // SAFETY: OSXSAVE says that the processor has XGETBV and that the system allows it.
    let enabled = unsafe { _xgetbv(0) };
    enabled & TILES == TILES
}

/// Asks Linux for the tiles, for all threads of this process; the error is a negative number.
fn permission() -> Result<(), i64> {
    const ARCH_PRCTL: i64 = 158;
    const ARCH_REQ_XCOMP_PERM: u64 = 0x1023;
    const XTILEDATA: u64 = 18;
    let answer: i64;
    // SAFETY: a system call that takes two numbers and no memory; `syscall` overwrites rcx and r11.
    unsafe {
        asm!(
            "syscall",
            inlateout("rax") ARCH_PRCTL => answer,
            in("rdi") ARCH_REQ_XCOMP_PERM,
            in("rsi") XTILEDATA,
            lateout("rcx") _,
            lateout("r11") _,
            options(nostack),
        );
    }
    if answer == 0 { Ok(()) } else { Err(answer) }
}

thread_local! {
    /// Whether an [`Amx`] of this thread lives: a second one would take the first one's tiles away.
    static TAKEN: Cell<bool> = const { Cell::new(false) };
}

/// The tiles of this thread, configured; given back when dropped.
pub(super) struct Amx {
    /// The configuration is the thread's, so this must not leave it.
    _here: PhantomData<*const ()>,
}

/// What LDTILECFG reads: the shapes of the tiles.
#[repr(C, align(64))]
struct Shapes {
    palette: u8,
    start_row: u8,
    reserved: [u8; 14],
    row_bytes: [u16; 16],
    rows: [u8; 16],
}

impl Amx {
    /// The tiles, where there are any and nobody else on this thread has them.
    pub(super) fn new() -> Option<Self> {
        if !permitted() || TAKEN.replace(true) {
            return None;
        }
        let (mut row_bytes, mut rows) = ([0; 16], [0; 16]);
        row_bytes[..8].fill(ROW as u16);
        rows[..8].fill(16);
        let shapes = Shapes { palette: 1, start_row: 0, reserved: [0; 14], row_bytes, rows };
        // SAFETY: the processor and the system allow tiles (`permitted`), `shapes` is 64 bytes of a
        // configuration within the palette's bounds (`built_in`), and every tile register, which
        // this zeroes, is said to be overwritten.
        unsafe {
            asm!(
                "ldtilecfg [{shapes}]",
                shapes = in(reg) &raw const shapes,
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
                options(nostack, readonly, preserves_flags),
            );
        }
        Some(Self { _here: PhantomData })
    }
}

impl Drop for Amx {
    fn drop(&mut self) {
        // SAFETY: `new` found the tiles allowed; nothing of theirs is wanted any more.
        unsafe {
            asm!(
                "tilerelease",
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
                options(nostack, nomem, preserves_flags),
            );
        }
        TAKEN.set(false);
    }
}

impl Tiles for Amx {
    fn multiply(&mut self, a: [&[Tile]; 2], b: [&[Tile]; 2], sums: &mut Block) {
        let tiles = a[0].len();
        assert!(a.iter().chain(&b).all(|side| side.len() == tiles), "factors of one length");
        if tiles == 0 {
            *sums = super::NOTHING;
            return;
        }
        // SAFETY: the tiles of this thread are configured as 16 rows of 64 bytes (`new`; an `Amx`
        // stays on its thread and is the only one there). The loop runs `tiles` times, at least once; each time it reads one
        // `Tile`, 16 rows of 64 bytes, from each of four slices of that many, and steps to the
        // next. The stores write the four `Sums` of `sums`, 1,024 bytes each, one after the other.
        // Every tile register used is said to be overwritten, and none is read before it is
        // written here.
        unsafe {
            asm!(
                "tilezero tmm0",
                "tilezero tmm1",
                "tilezero tmm2",
                "tilezero tmm3",
                "2:",
                "tileloadd tmm4, [{a0} + {row}*1]",
                "tileloadd tmm6, [{b0} + {row}*1]",
                "tdpbf16ps tmm0, tmm4, tmm6",
                "tileloadd tmm7, [{b1} + {row}*1]",
                "tdpbf16ps tmm1, tmm4, tmm7",
                "tileloadd tmm5, [{a1} + {row}*1]",
                "tdpbf16ps tmm2, tmm5, tmm6",
                "tdpbf16ps tmm3, tmm5, tmm7",
                "add {a0}, 1024",
                "add {a1}, 1024",
                "add {b0}, 1024",
                "add {b1}, 1024",
                "sub {tiles}, 1",
                "jnz 2b",
                "tilestored [{sums} + {row}*1], tmm0",
                "tilestored [{sums} + {row}*1 + 1024], tmm1",
                "tilestored [{sums} + {row}*1 + 2048], tmm2",
                "tilestored [{sums} + {row}*1 + 3072], tmm3",
                a0 = inout(reg) a[0].as_ptr() => _,
                a1 = inout(reg) a[1].as_ptr() => _,
                b0 = inout(reg) b[0].as_ptr() => _,
                b1 = inout(reg) b[1].as_ptr() => _,
                tiles = inout(reg) tiles => _,
                sums = in(reg) sums.as_mut_ptr(),
                row = in(reg) ROW,
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
                options(nostack),
            );
        }
    }
}
