//! The C interface of the instrument: all unsafe code of this package.
//!
//! What the instrument promises, and each argument below relies on: a handle is the result of `peer_prepare`, is used
//! by one thread at a time, and by no call after `peer_free`; arrays have the lengths that are given beside them, are
//! initialised, and nothing else writes to them during a call. A panic does not leave an `extern "C"` function: it ends
//! the process with its message.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int};
use std::slice;
use std::sync::LazyLock;

use crate::peer::Peer;
use crate::variants::VARIANTS;
use crate::{Hit, Ray};

static NAMES: LazyLock<CString> = LazyLock::new(|| {
    let names: Vec<&str> = VARIANTS.iter().map(|(name, _)| *name).collect();
    CString::new(names.join("\n")).expect("no name has a NUL")
});

/// The names of the rows, one a line; valid for ever.
// SAFETY: no other function of this name is linked into a library that is opened on its own.
#[unsafe(no_mangle)]
pub extern "C" fn peer_variants() -> *const c_char {
    NAMES.as_ptr()
}

/// A row over `n` triangles of nine floats.
///
/// # Safety
/// `name` is a C string, `triangles` has `9 * n` floats.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_prepare(name: *const c_char, triangles: *const f32, n: u32) -> *mut Peer {
    // SAFETY: a C string, by contract, which is not kept beyond this call.
    let name = unsafe { CStr::from_ptr(name) };
    // SAFETY: that many floats, by contract; they are copied here.
    let triangles = unsafe { slice::from_raw_parts(triangles, 9 * n as usize) };
    Box::into_raw(Box::new(Peer::prepare(&name.to_string_lossy(), triangles)))
}

/// Builds on `threads` threads.
///
/// # Safety
/// `peer` is a handle.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_build(peer: *mut Peer, threads: c_int) {
    // SAFETY: a live `Box` that only this thread uses, by contract.
    let peer = unsafe { &mut *peer };
    peer.build(usize::try_from(threads).unwrap_or(0).max(1));
}

/// The closest hits of `n` rays.
///
/// # Safety
/// `peer` is a handle that was built, and there are `n` rays and hits.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_closest(peer: *const Peer, rays: *const Ray, hits: *mut Hit, n: usize) {
    // SAFETY: a live `Box` that nothing changes during this call, by contract.
    let peer = unsafe { &*peer };
    // SAFETY: `n` initialised rays, by contract; eight floats each on both sides.
    let rays = unsafe { slice::from_raw_parts(rays, n) };
    // SAFETY: `n` initialised hits that only this call uses, by contract; a float and a u32 each on both sides.
    let hits = unsafe { slice::from_raw_parts_mut(hits, n) };
    peer.closest(rays, hits);
}

/// Whether each of `n` rays hits anything; 0 where the row has no such query.
///
/// # Safety
/// `peer` is a handle that was built, and there are `n` rays and bytes.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_any(peer: *const Peer, rays: *const Ray, occluded: *mut u8, n: usize) -> c_int {
    // SAFETY: a live `Box` that nothing changes during this call, by contract.
    let peer = unsafe { &*peer };
    // SAFETY: `n` initialised rays, by contract; eight floats each on both sides.
    let rays = unsafe { slice::from_raw_parts(rays, n) };
    // SAFETY: `n` initialised bytes that only this call uses, by contract.
    let occluded = unsafe { slice::from_raw_parts_mut(occluded, n) };
    c_int::from(peer.any(rays, occluded))
}

/// What the structure keeps beside its input, in bytes.
///
/// # Safety
/// `peer` is a handle that was built.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_bytes(peer: *const Peer) -> u64 {
    // SAFETY: a live `Box` that nothing changes during this call, by contract.
    let peer = unsafe { &*peer };
    peer.bytes() as u64
}

/// Ends a row.
///
/// # Safety
/// `peer` is a handle, and this is its last use.
// SAFETY: as for `peer_variants`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_free(peer: *mut Peer) {
    // SAFETY: from `Box::into_raw` in `peer_prepare`, and not used again, by contract.
    drop(unsafe { Box::from_raw(peer) });
}
