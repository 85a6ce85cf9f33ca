//! Embree 3 or 4 by its C interface, opened at run time: nothing is linked.
//!
//! The two differ in what a query takes beside the scene and the ray: 3 a context before the ray, 4 arguments after
//! it, which may be null.
#![expect(unsafe_code, reason = "a C library can be called in no other way")]

use std::ffi::{OsString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicIsize, Ordering};

use libloading::{Library, Symbol};

use crate::tracer::{Hit, Peer, Ray, Tracer, Triangles};

type Handle = *mut c_void;
type Monitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

/// RTCRayHit, of which RTCRay is the first part. Embree 3 and 4 lay it out alike; 4 has one more word behind, which is
/// padding in 3, since the whole is aligned to 16 bytes.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: [u32; 2],
}

/// RTCIntersectContext of version 3: flags, a filter, the instance's number, and room for what builds of it may add.
#[repr(C, align(16))]
struct Context3 {
    flags: u64,
    filter: *const c_void,
    instance: [u32; 4],
}

const INVALID: u32 = u32::MAX;

/// How a scene is built and traversed.
#[derive(Clone, Copy)]
pub struct Mode {
    quality: u32,
    is_robust: bool,
}

impl Mode {
    pub const ALL: [Self; 4] = [
        Self { quality: 1, is_robust: false },
        Self { quality: 1, is_robust: true },
        Self { quality: 2, is_robust: false },
        Self { quality: 2, is_robust: true },
    ];

    pub fn name(self) -> String {
        format!("{}{}", ["low", "medium", "high"][self.quality as usize], if self.is_robust { " robust" } else { "" })
    }
}

/// The library, opened; it stays so until the process ends, since its threads outlive what they have built.
pub struct Embree {
    library: &'static Library,
    version: isize,
}

macro_rules! c_function {
    ($self:ident, $name:literal, $type:ty) => {{
        // SAFETY: the type is that of the function in the public headers of Embree 3 and 4.
        let symbol: Result<Symbol<$type>, _> = unsafe { $self.library.get(concat!($name, "\0").as_bytes()) };
        symbol.ok().map(|symbol| *symbol)
    }};
}

impl Embree {
    /// The one that the variable `EMBREE_LIBRARY` names, or else the newest that is installed.
    pub fn open() -> Option<Self> {
        let installed =
            ["libembree4.so.4", "libembree4.so", "libembree3.so.3", "libembree3.so", "libembree4.dylib", "embree4.dll"];
        let names: Vec<OsString> = match std::env::var_os("EMBREE_LIBRARY") {
            Some(own) => vec![own],
            None => installed.map(OsString::from).into(),
        };
        names.into_iter().find_map(|name| {
            // SAFETY: a library of this name is Embree, whose initialisers have no conditions.
            let library = unsafe { Library::new(name) }.ok()?;
            let mut embree = Self { library: Box::leak(Box::new(library)), version: 0 };
            let device = embree.device()?;
            let property = c_function!(embree, "rtcGetDeviceProperty", extern "C" fn(Handle, u32) -> isize)?;
            embree.version = property(device, 0);
            c_function!(embree, "rtcReleaseDevice", extern "C" fn(Handle))?(device);
            (30_000..50_000).contains(&embree.version).then_some(embree)
        })
    }

    pub fn version(&self) -> String {
        format!("{}.{}.{}", self.version / 10_000, self.version / 100 % 100, self.version % 100)
    }

    fn device(&self) -> Option<Handle> {
        let device = c_function!(self, "rtcNewDevice", extern "C" fn(*const c_char) -> Handle)?(null());
        (!device.is_null()).then_some(device)
    }

    /// Builds a scene of one geometry over `vertices`.
    pub fn build(&self, vertices: &[f32], mode: Mode) -> Option<Box<dyn Peer>> {
        type SetBuffer = extern "C" fn(Handle, u32, u32, u32, *const c_void, usize, usize, usize);
        let new_scene = c_function!(self, "rtcNewScene", extern "C" fn(Handle) -> Handle)?;
        let set_flags = c_function!(self, "rtcSetSceneFlags", extern "C" fn(Handle, u32))?;
        let set_quality = c_function!(self, "rtcSetSceneBuildQuality", extern "C" fn(Handle, u32))?;
        let new_geometry = c_function!(self, "rtcNewGeometry", extern "C" fn(Handle, u32) -> Handle)?;
        let set_buffer = c_function!(self, "rtcSetSharedGeometryBuffer", SetBuffer)?;
        let commit_geometry = c_function!(self, "rtcCommitGeometry", extern "C" fn(Handle))?;
        let attach = c_function!(self, "rtcAttachGeometry", extern "C" fn(Handle, Handle) -> u32)?;
        let release_geometry = c_function!(self, "rtcReleaseGeometry", extern "C" fn(Handle))?;
        let commit_scene = c_function!(self, "rtcCommitScene", extern "C" fn(Handle))?;
        let error = c_function!(self, "rtcGetDeviceError", extern "C" fn(Handle) -> u32)?;
        let set_monitor = c_function!(
            self,
            "rtcSetDeviceMemoryMonitorFunction",
            extern "C" fn(Handle, Option<Monitor>, *mut c_void)
        )?;

        let device = self.device()?;
        let bytes: &'static AtomicIsize = Box::leak(Box::default());
        set_monitor(device, Some(count_bytes), std::ptr::from_ref(bytes).cast_mut().cast());
        let scene = new_scene(device);
        set_flags(scene, if mode.is_robust { 4 } else { 0 });
        set_quality(scene, mode.quality);
        let geometry = new_geometry(device, 0);
        let vertex_count = (vertices.len() - 1) / 3;
        let indices: &'static [u32] = Box::leak((0..vertex_count as u32).collect::<Box<[u32]>>());
        let vertices: &'static [f32] = Box::leak(vertices.into());
        set_buffer(geometry, 1, 0, FLOAT3, vertices.as_ptr().cast(), 0, 12, vertex_count);
        set_buffer(geometry, 0, 0, UINT3, indices.as_ptr().cast(), 0, 12, vertex_count / 3);
        commit_geometry(geometry);
        attach(scene, geometry);
        release_geometry(geometry);
        commit_scene(scene);
        if error(device) != 0 {
            return None;
        }
        let version3 = self.version < 40_000;
        let queries = if version3 {
            let intersect = c_function!(self, "rtcIntersect1", Query3)?;
            let occluded = c_function!(self, "rtcOccluded1", Query3)?;
            Queries::Version3 { intersect, occluded }
        } else {
            let intersect = c_function!(self, "rtcIntersect1", Query4)?;
            let occluded = c_function!(self, "rtcOccluded1", Query4)?;
            Queries::Version4 { intersect, occluded }
        };
        Some(Box::new(Scene { scene, queries, bytes }))
    }
}

const FLOAT3: u32 = 0x9003;
const UINT3: u32 = 0x5003;

/// Nine floats a triangle, and one more: the library may read four floats at the last vertex.
pub fn vertices(triangles: &Triangles) -> Vec<f32> {
    triangles.0.as_flattened().as_flattened().iter().copied().chain([0.0]).collect()
}

extern "C" fn count_bytes(bytes: *mut c_void, change: isize, _: bool) -> bool {
    // SAFETY: the pointer is the one that was given with this function, to a counter that is never freed.
    let counter = unsafe { &*bytes.cast::<AtomicIsize>() };
    counter.fetch_add(change, Ordering::Relaxed);
    true
}

type Query3 = unsafe extern "C" fn(Handle, *mut Context3, *mut RayHit);
type Query4 = unsafe extern "C" fn(Handle, *mut RayHit, *const c_void);

enum Queries {
    Version3 { intersect: Query3, occluded: Query3 },
    Version4 { intersect: Query4, occluded: Query4 },
}

/// Never released: the process ends when all are measured.
struct Scene {
    scene: Handle,
    queries: Queries,
    bytes: &'static AtomicIsize,
}

fn ray_hit(ray: &Ray) -> RayHit {
    RayHit {
        origin: ray.origin,
        t_near: ray.t_min,
        direction: ray.direction,
        time: 0.0,
        t_far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        primitive: INVALID,
        geometry: INVALID,
        instance: [INVALID; 2],
    }
}

fn context() -> Context3 {
    Context3 { flags: 0, filter: null(), instance: [INVALID; 4] }
}

impl Scene {
    fn query(&self, ray: &Ray, is_any: bool) -> RayHit {
        let mut hit = ray_hit(ray);
        match self.queries {
            Queries::Version3 { intersect, occluded } => {
                let query = if is_any { occluded } else { intersect };
                // SAFETY: the scene is committed and never released; context and ray are those of version 3, aligned.
                unsafe { query(self.scene, &mut context(), &mut hit) };
            }
            Queries::Version4 { intersect, occluded } => {
                let query = if is_any { occluded } else { intersect };
                // SAFETY: the scene is committed and never released, the ray is aligned, and the arguments may be null.
                unsafe { query(self.scene, &mut hit, null_mut::<c_void>()) };
            }
        }
        hit
    }
}

impl Tracer for Scene {
    fn closest(&self, ray: &Ray) -> Hit {
        let hit = self.query(ray, false);
        if hit.geometry == INVALID { Hit::MISS } else { Hit { t: hit.t_far, primitive: hit.primitive } }
    }

    fn any(&self, ray: &Ray) -> bool {
        self.query(ray, true).t_far < 0.0
    }

    fn bytes(&self) -> Option<usize> {
        usize::try_from(self.bytes.load(Ordering::Relaxed)).ok()
    }
}
