//! From plain data to something that answers rays.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use bvh_flat::{
    BuildConfig, BuildError, BuildObserver, BvhAggregate, ExactMesh, InvalidBvh, MeshBvh, SimdWidth, WideLayout,
    WideMesh,
};
use geometry::{Bounds3, Hit, HitVisitor, Interval, Kernels, Shape, Sphere, TraversalRay, TriangleMesh, Visit};
use primitive::{GeometricPrimitive, HitKind, Primitive, SurfaceInteraction, TransformedPrimitive};

use crate::{Geometry, Scene, SceneShape};

/// The closed set of what the objects of a scene consist of. An enum, so that a ray is not dispatched through pointers.
/// `M` is what a mesh is made to: [`WideMesh`], unless other trees or kernels are to be compared.
#[derive(Debug)]
pub enum ScenePrimitive<M = WideMesh> {
    /// A mesh with its own tree: one primitive of the aggregate around it.
    Mesh(GeometricPrimitive<M>),
    /// A sphere.
    Sphere(GeometricPrimitive<Sphere>),
    /// An object, placed.
    Instance(TransformedPrimitive<Arc<ObjectAggregate<M>>>),
}

/// A compiled object: its geometries first, then its instances, each in scene order, with a tree over all.
pub type ObjectAggregate<M = WideMesh> = BvhAggregate<ScenePrimitive<M>>;

macro_rules! each {
    ($self:expr, $primitive:ident => $body:expr) => {
        match $self {
            ScenePrimitive::Mesh($primitive) => $body,
            ScenePrimitive::Sphere($primitive) => $body,
            ScenePrimitive::Instance($primitive) => $body,
        }
    };
}

impl<M: Shape> Primitive for ScenePrimitive<M> {
    fn world_bound(&self) -> Bounds3 {
        each!(self, p => p.world_bound())
    }

    fn primitive_count(&self) -> u64 {
        each!(self, p => p.primitive_count())
    }

    fn visit_hits(&self, ray: &TraversalRay, interval: Interval, kind: HitKind, visitor: &mut dyn HitVisitor) -> Visit {
        each!(self, p => p.visit_hits(ray, interval, kind, visitor))
    }

    fn intersect(&self, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
        each!(self, p => p.intersect(ray, interval))
    }

    fn intersect_p(&self, ray: &TraversalRay, interval: Interval) -> bool {
        each!(self, p => p.intersect_p(ray, interval))
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        each!(self, p => p.interaction(ray, hit))
    }
}

/// What a mesh of a scene is made to: a shape with a tree. Clones share it.
pub trait MeshTree: Shape + Clone {
    /// Builds a tree over `mesh`, telling `observer` of each phase.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration or a size that the builder refuses.
    fn build(mesh: Arc<TriangleMesh>, config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError>;

    /// The mesh.
    fn mesh(&self) -> &Arc<TriangleMesh>;

    /// What is kept beside the mesh itself, in bytes.
    fn memory(&self) -> usize;

    /// How long a cache file with the tree is, in bytes.
    fn file_length(&self) -> u64;
}

impl MeshTree for WideMesh {
    fn build(mesh: Arc<TriangleMesh>, config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        Self::build_observed(mesh, config, WideLayout::default(), observer)
    }

    fn mesh(&self) -> &Arc<TriangleMesh> {
        self.mesh()
    }

    fn memory(&self) -> usize {
        self.memory()
    }

    fn file_length(&self) -> u64 {
        self.file_length()
    }
}

impl MeshTree for ExactMesh {
    fn build(mesh: Arc<TriangleMesh>, config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        Ok(MeshBvh::build_observed(mesh, config, observer)?.exact())
    }

    fn mesh(&self) -> &Arc<TriangleMesh> {
        self.mesh()
    }

    fn memory(&self) -> usize {
        self.memory()
    }

    /// That of the binary tree.
    fn file_length(&self) -> u64 {
        self.bvh().file_length()
    }
}

impl<K: Kernels + Clone> MeshTree for MeshBvh<K> {
    fn build(mesh: Arc<TriangleMesh>, config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Self, BuildError> {
        Ok(MeshBvh::build_observed(mesh, config, observer)?.with_kernels())
    }

    fn mesh(&self) -> &Arc<TriangleMesh> {
        self.mesh()
    }

    fn memory(&self) -> usize {
        self.memory()
    }

    fn file_length(&self) -> u64 {
        self.bvh().file_length()
    }
}

/// A scene with its trees: one for each mesh, one for each object.
///
/// Its primitives are numbered depth first: the world's geometries in scene order, then its instances, each like a copy
/// of its object. Of hits at the same `t`, the one with the smaller (instance, geometry, primitive) wins.
#[derive(Debug)]
pub struct CompiledScene<M = WideMesh> {
    scene: Arc<Scene>,
    meshes: Vec<M>,
    /// As the scene numbers them; the world is the first.
    objects: Vec<CompiledObject<M>>,
}

#[derive(Debug)]
struct CompiledObject<M> {
    aggregate: Arc<ObjectAggregate<M>>,
    /// For each instance how many instance paths come before it in this object, itself not counted; behind the last,
    /// how many there are.
    paths_before: Vec<u64>,
}

/// A primitive's name in a scene, as other programs know it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PrimitiveName {
    /// The instance path, counted depth first in scene order; 0 is the world itself.
    pub instance: u64,
    /// The shape, counted in scene order over the whole file.
    pub geometry: u32,
    /// The triangle in file order within its mesh; 0 for a sphere.
    pub primitive: u32,
}

impl CompiledScene {
    /// Builds the trees of `scene`: of each mesh once, however many geometries share it. Meshes are [`WideMesh`]es, so
    /// that every decision within one is exact.
    ///
    /// # Errors
    /// [`BuildError`] for a configuration that the builder refuses, or a mesh that is too large.
    pub fn build(
        scene: impl Into<Arc<Scene>>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        Self::build_with(scene, config, observer)
    }
}

impl<M: MeshTree> CompiledScene<M> {
    /// As [`build`](CompiledScene::build), with meshes made to `M`.
    ///
    /// # Errors
    /// As [`build`](CompiledScene::build).
    pub fn build_with(
        scene: impl Into<Arc<Scene>>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
    ) -> Result<Self, BuildError> {
        Self::build_by(scene, config, observer, |mesh| M::build(mesh, config, observer))
    }

    /// As [`build`](CompiledScene::build), with `build` making the tree of each mesh, and `config` that of each object.
    ///
    /// # Errors
    /// As [`build`](CompiledScene::build).
    pub fn build_by(
        scene: impl Into<Arc<Scene>>,
        config: &BuildConfig,
        observer: &dyn BuildObserver,
        build: impl Fn(Arc<TriangleMesh>) -> Result<M, BuildError>,
    ) -> Result<Self, BuildError> {
        let scene = scene.into();
        let mut meshes: HashMap<*const TriangleMesh, usize> = HashMap::new();
        let mut distinct = Vec::new();
        for geometry in scene.geometries() {
            if let SceneShape::Mesh(mesh) = &geometry.shape
                && let Entry::Vacant(entry) = meshes.entry(Arc::as_ptr(mesh))
            {
                entry.insert(distinct.len());
                distinct.push(build(Arc::clone(mesh))?);
            }
        }
        let mesh = |mesh: &Arc<TriangleMesh>| distinct[meshes[&Arc::as_ptr(mesh)]].clone();
        let aggregate = |_, members| BvhAggregate::build_observed(members, config, observer);
        let objects = compile_objects(&scene, mesh, aggregate)?;
        Ok(Self { scene, meshes: distinct, objects })
    }

    /// The same scene and trees, with `shape` of every mesh in place of the mesh, and those over objects traversed with
    /// `width`: to compare other kernels.
    ///
    /// # Errors
    /// [`InvalidBvh::Geometry`] where a shape is not in the bounds of its mesh.
    pub fn with_meshes<N: MeshTree>(
        &self,
        width: SimdWidth,
        shape: impl Fn(&M) -> N,
    ) -> Result<CompiledScene<N>, InvalidBvh> {
        let meshes: Vec<N> = self.meshes.iter().map(shape).collect();
        let places: HashMap<*const TriangleMesh, usize> =
            self.meshes.iter().enumerate().map(|(i, mesh)| (Arc::as_ptr(mesh.mesh()), i)).collect();
        let mesh = |mesh: &Arc<TriangleMesh>| meshes[places[&Arc::as_ptr(mesh)]].clone();
        let aggregate = |index: usize, members| -> Result<_, InvalidBvh> {
            let bvh = self.objects[index].aggregate.bvh().clone();
            Ok(BvhAggregate::from_parts(members, bvh)?.with_simd_width(width))
        };
        let objects = compile_objects(&self.scene, mesh, aggregate)?;
        Ok(CompiledScene { scene: Arc::clone(&self.scene), meshes, objects })
    }
}

/// Every object of `scene`, with `mesh` of each mesh, and `aggregate` of the object's number and members.
fn compile_objects<M: Shape, E>(
    scene: &Scene,
    mesh: impl Fn(&Arc<TriangleMesh>) -> M,
    aggregate: impl Fn(usize, Vec<ScenePrimitive<M>>) -> Result<ObjectAggregate<M>, E>,
) -> Result<Vec<CompiledObject<M>>, E> {
    let mut objects: Vec<Option<CompiledObject<M>>> = scene.objects().iter().map(|_| None).collect();
    for index in order_of_need(scene) {
        let object = &scene.objects()[index];
        let geometries = object.geometries.iter().map(|&number| {
            let Geometry { shape, surface, media } = &scene.geometries()[number as usize];
            match shape {
                SceneShape::Sphere(s) => ScenePrimitive::Sphere(GeometricPrimitive::new(*s, *surface, *media)),
                SceneShape::Mesh(m) => ScenePrimitive::Mesh(GeometricPrimitive::new(mesh(m), *surface, *media)),
            }
        });
        let mut members: Vec<ScenePrimitive<M>> = geometries.collect();
        let mut paths_before = vec![0];
        for (i, instance) in object.instances.iter().enumerate() {
            if let Some(inner) = &objects[instance.object.index()] {
                let placed = TransformedPrimitive::new(Arc::clone(&inner.aggregate), instance.placement.clone());
                members.push(ScenePrimitive::Instance(placed));
                paths_before.push(paths_before[i] + 1 + inner.path_count());
            }
        }
        objects[index] = Some(CompiledObject { aggregate: Arc::new(aggregate(index, members)?), paths_before });
    }
    Ok(objects.into_iter().flatten().collect())
}

impl<M: MeshTree> CompiledScene<M> {
    /// The aggregate over the whole scene, in world space.
    pub fn world(&self) -> &ObjectAggregate<M> {
        &self.objects[0].aggregate
    }

    /// The same, to be kept beyond this scene.
    pub fn shared_world(&self) -> Arc<ObjectAggregate<M>> {
        Arc::clone(&self.objects[0].aggregate)
    }

    /// The trees over meshes, each once.
    pub fn meshes(&self) -> &[M] {
        &self.meshes
    }

    /// The trees over objects, as the scene numbers them.
    pub fn objects(&self) -> impl Iterator<Item = &ObjectAggregate<M>> {
        self.objects.iter().map(|object| &*object.aggregate)
    }

    /// The scene's data.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// What is kept beside the scene's own data, in bytes: the trees, and what their members are.
    pub fn memory(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(MeshTree::memory).sum();
        let objects = self.objects().map(|object| object.memory() + size_of_val(object.list().members()));
        meshes + objects.sum::<usize>()
    }

    /// How many instance paths there are; the world itself not counted.
    pub fn path_count(&self) -> u64 {
        self.objects[0].path_count()
    }

    /// The name of the primitive of a hit of [`world`](Self::world).
    pub fn name(&self, hit: &Hit) -> PrimitiveName {
        let mut name = PrimitiveName::default();
        let (mut index, mut hit) = (0, *hit);
        loop {
            let object = &self.scene.objects()[index];
            let compiled = &self.objects[index];
            let (member, inner) = compiled.aggregate.list().member_of(&hit);
            hit = inner;
            let Some(instance) = member.checked_sub(object.geometries.len()) else {
                name.geometry = object.geometries[member];
                name.primitive = hit.primitive as u32;
                return name;
            };
            name.instance += 1 + compiled.paths_before[instance];
            index = object.instances[instance].object.index();
        }
    }
}

impl<M> CompiledObject<M> {
    fn path_count(&self) -> u64 {
        self.paths_before[self.paths_before.len() - 1]
    }
}

/// The objects such that each comes behind those that it instances; every object, the world last.
fn order_of_need(scene: &Scene) -> Vec<usize> {
    let objects = scene.objects();
    let mut order = Vec::with_capacity(objects.len());
    let mut entered = vec![false; objects.len()];
    // Depth first without recursion: an object is entered, then its instances, then left. A nesting of any depth.
    for start in (0..objects.len()).rev() {
        let mut stack = vec![(start, false)];
        while let Some((index, leave)) = stack.pop() {
            if leave {
                order.push(index);
            } else if !std::mem::replace(&mut entered[index], true) {
                stack.push((index, true));
                stack.extend(objects[index].instances.iter().map(|i| (i.object.index(), false)));
            }
        }
    }
    order
}
