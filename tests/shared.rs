//! Whatever a renderer keeps can be shared among its threads, and sent to them: this compiles, or it does not.

use std::sync::Arc;

use bvh_flat::cache::{CacheError, CacheInfo, Cached, GeometryKey, TreeOptions};
use bvh_flat::geometry::{
    AnimatedTransform, AnimatedTransformError, Bounds3, ClosestHit, FirstHit, Hit, Keyframe, MeshError, Naive, Ray,
    Shape, Sphere, SphereError, SurfacePoint, Transform, TransformError, TraversalRay, TriangleMesh, Watertight,
};
use bvh_flat::primitive::{
    GeometricPrimitive, MediumBoundary, Placement, Primitive, PrimitiveList, Surface, SurfaceInteraction,
    TransformedPrimitive,
};
use bvh_flat::{
    BuildConfig, BuildError, BvhAggregate, ExactMesh, FlatBvh, InvalidBvh, InvalidWideTree, MeshBvh, RaySegment,
    RefitError, SimdWidth, WideMesh,
};

fn is_shared<T: Send + Sync + 'static>() {}

#[test]
fn data_trees_and_errors_are_send_and_sync() {
    is_shared::<(TriangleMesh, Sphere, Bounds3, Transform, AnimatedTransform, Keyframe, Placement)>();
    is_shared::<(Ray, TraversalRay, Hit, SurfacePoint, ClosestHit, FirstHit)>();
    is_shared::<(WideMesh, MeshBvh<Watertight>, MeshBvh<Naive>, ExactMesh, FlatBvh)>();
    is_shared::<(BuildConfig, RaySegment, SimdWidth)>();
    is_shared::<(GeometryKey, TreeOptions, CacheInfo, Cached<WideMesh>)>();
    is_shared::<(SurfaceInteraction, Surface, MediumBoundary)>();
    is_shared::<(BuildError, CacheError, InvalidBvh, InvalidWideTree, RefitError)>();
    is_shared::<(MeshError, SphereError, TransformError, AnimatedTransformError)>();

    type Mesh = GeometricPrimitive<WideMesh>;
    is_shared::<(BvhAggregate<Mesh>, PrimitiveList<Mesh>)>();
    is_shared::<TransformedPrimitive<Mesh>>();
    is_shared::<BvhAggregate<TransformedPrimitive<Arc<BvhAggregate<Mesh>>>>>();
    is_shared::<(BvhAggregate<Box<dyn Primitive>>, GeometricPrimitive<Arc<dyn Shape>>)>();
}
