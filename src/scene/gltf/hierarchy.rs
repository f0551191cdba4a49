//! Nodes: their order and where they stand in the world.

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
use gltf::json::Index;

use super::document::Document;
use super::exact;
use super::fault::{Fault, place};

/// A node of the scene with its transform to the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Index of the node.
    pub node: usize,
    /// From the node's coordinates to the world's.
    pub world: DAffine3,
}

/// All nodes below the scene's roots, parents before children, in the order of the file. In a file without scenes every
/// node without a parent is a root.
pub(super) fn place_nodes(document: &Document, scene: usize) -> Result<Vec<Placed>, Fault> {
    let parents = check_forest(document)?;
    let nodes = &document.root.nodes;
    let roots: Vec<usize> = match document.root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(Index::value).collect(),
        None => (0..nodes.len()).filter(|&node| parents[node].is_none()).collect(),
    };
    let mut placed = Vec::new();
    // A stack of our own: hierarchies may be deeper than the thread's.
    let mut waiting: Vec<_> = roots.into_iter().rev().map(|root| (root, DAffine3::IDENTITY)).collect();
    while let Some((node, parent)) = waiting.pop() {
        let here = node_place(document, node);
        let world = parent * local(&document.exact.nodes[node], &here)?;
        if !world.is_finite() {
            return Err(Fault::invalid(here, "its transform is not finite", "correct the transforms above it"));
        }
        placed.push(Placed { node, world });
        let children = nodes[node].children.as_deref().unwrap_or_default();
        waiting.extend(children.iter().rev().map(|child| (child.value(), world)));
    }
    Ok(placed)
}

/// `nodes[3] "Lamp"`.
pub(super) fn node_place(document: &Document, node: usize) -> String {
    place("nodes", node, document.root.nodes[node].name.as_deref())
}

/// The parent of each node, once it is sure that roots have none and that no node descends from itself.
fn check_forest(document: &Document) -> Result<Vec<Option<usize>>, Fault> {
    let nodes = &document.root.nodes;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            let child = child.value();
            if let Some(other) = parents[child].replace(parent) {
                let problem = format!("is a child of both nodes[{other}] and nodes[{parent}]");
                return Err(Fault::invalid(node_place(document, child), problem, REMEDY));
            }
        }
    }
    // With one parent each, a node that descends from itself lies on a ring, which walking upwards closes.
    let mut seen_in_walk = vec![usize::MAX; nodes.len()];
    for start in 0..nodes.len() {
        let mut next = Some(start);
        while let Some(node) = next {
            match seen_in_walk[node] {
                usize::MAX => seen_in_walk[node] = start,
                walk if walk == start => {
                    return Err(Fault::invalid(node_place(document, node), "is its own descendant (a cycle)", REMEDY));
                }
                _ => break,
            }
            next = parents[node];
        }
    }
    for (number, scene) in document.root.scenes.iter().enumerate() {
        let mut listed = vec![false; nodes.len()];
        for root in &scene.nodes {
            let root = root.value();
            let problem = match parents[root] {
                Some(parent) => format!("is a root of scenes[{number}] and yet a child of nodes[{parent}]"),
                None if listed[root] => format!("is listed twice in scenes[{number}]"),
                None => {
                    listed[root] = true;
                    continue;
                }
            };
            return Err(Fault::invalid(node_place(document, root), problem, REMEDY));
        }
    }
    Ok(parents)
}

const REMEDY: &str = "give every node one parent, or list it once in a scene";

/// `M`, or `T R S`, as the node gives it.
fn local(node: &exact::Node, place: &str) -> Result<DAffine3, Fault> {
    let Some(m) = node.matrix else {
        let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        return compose(node.translation.unwrap_or([0.0; 3]), [x, y, z, w], node.scale.unwrap_or([1.0; 3]), place);
    };
    // Single precision writers leave rounding errors in the last row, not more.
    if [m[3], m[7], m[11], m[15] - 1.0].iter().any(|entry| entry.abs() > 1e-6) {
        let problem = "its matrix is a projection, not an affine map";
        return Err(Fault::invalid(place, problem, "make its last row 0 0 0 1"));
    }
    let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

/// `T R S`, with the rotation `(x, y, z, w)` normalised: files hold it in single precision.
pub(super) fn compose(
    translation: [f64; 3],
    rotation: [f64; 4],
    scale: [f64; 3],
    place: &str,
) -> Result<DAffine3, Fault> {
    let rotation = DQuat::from_array(rotation);
    let length = rotation.length();
    // Away from one it is no rounding error but a mistake whose meaning is open.
    if !(length > 0.5 && length < 2.0) {
        let problem = format!("its rotation has length {length}");
        return Err(Fault::invalid(place, problem, "give a unit quaternion x, y, z, w"));
    }
    let rotation = DQuat::from_vec4(DVec4::from(rotation) / length);
    Ok(DAffine3::from_scale_rotation_translation(scale.into(), rotation, translation.into()))
}
