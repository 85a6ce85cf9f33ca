//! The meshes that builders are timed with.

use geometry::TriangleMesh;
use hard_cases::adversarial_meshes;

#[test]
fn all_are_of_one_size_and_no_two_the_same() {
    let n = 1000;
    let meshes = adversarial_meshes(n, 1);
    for (i, (name, mesh)) in meshes.iter().enumerate() {
        assert!(mesh.len().abs_diff(n) <= n / 50, "{name}: {}", mesh.len());
        let bits = |mesh: &TriangleMesh| -> Vec<[u32; 3]> {
            mesh.positions().iter().map(|p| p.to_array().map(f32::to_bits)).collect()
        };
        assert!(meshes[..i].iter().all(|(_, other)| bits(other) != bits(mesh)), "{name}");
    }
}
