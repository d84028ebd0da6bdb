//! What is particular to a file of each kind, from its small sections.

use super::super::sphere_metrics::SphereMetrics;
use super::facts::{ClassInfo, ClipInfo, Details, TrackInfo};
use relume_formats::Result;
use relume_formats::basis::diffuse::NODES;
use relume_formats::basis::two_level::BYTES;
use relume_formats::container::{Kind, Reader, Sections, Stored};
use relume_formats::kinds::sphere_shadows::NO_ROW;
use relume_formats::kinds::transfer_images::Head;
use relume_formats::kinds::visibility_table::{DIRECTIONS, RADII, STORED_DIRECTIONS};
use relume_formats::kinds::{BrdfBasis, Environment, SparseTransfer, SphereSet, SphereShadows, StoredScene, Textures, sparse_transfer};
use relume_formats::shape::DeformingMesh;
use relume_formats::state::Animation;
use std::io::Read;
use std::path::Path;

/// What is particular to the file at `path`, of which `reader` has read the header.
pub(super) fn of(kind: Kind, path: &Path, reader: &mut Reader<impl Read>) -> Result<Details> {
    Ok(match kind {
        Kind::Scene => scene_details(StoredScene::read_file(path)?),
        Kind::Animation => animation_details(<Animation as Stored>::read_file(path)?),
        Kind::BrdfBasis => basis_details(&BrdfBasis::read_file(path)?),
        Kind::TransferImages => {
            reader.header().expect_kind(kind, relume_formats::kinds::TransferImages::VERSION, reader.place())?;
            let place = reader.place().clone();
            let mut next = || reader.next_section();
            images_details(&Head::decode(&mut Sections { place, next: &mut next })?)
        }
        Kind::HaarTable => Details::HaarTable { bitmaps: 65_536, coefficients: 16 },
        Kind::Environment => environment_details(Environment::read_file(path)?),
        Kind::Textures => {
            let textures = Textures::read_file(path)?;
            Details::Textures { uvs: textures.uvs.len(), sizes: textures.textures.iter().map(|t| t.texture.size).collect() }
        }
        Kind::SparseTransfer => {
            reader.header().expect_kind(kind, SparseTransfer::VERSION, reader.place())?;
            let place = reader.place().clone();
            let mut next = || reader.next_section();
            rows_details(&sparse_transfer::Meta::decode(&mut Sections { place, next: &mut next })?)
        }
        Kind::SphereSet => {
            let set = SphereSet::read_file(path)?;
            Details::SphereSet { metrics: SphereMetrics::of(&set), points: set.points.len(), iterations_done: set.history.len() }
        }
        Kind::Shape => shape_details(&DeformingMesh::read_file(path)?),
        Kind::SphereShadows => shadows_details(SphereShadows::read_file(path)?),
        Kind::VisibilityTable => Details::VisibilityTable {
            directions: DIRECTIONS,
            stored_directions: STORED_DIRECTIONS,
            radii: RADII,
            texels: DIRECTIONS,
            bytes_of_bitmaps: DIRECTIONS * RADII * BYTES,
        },
    })
}

fn shape_details(shape: &DeformingMesh) -> Details {
    Details::Shape {
        vertices: shape.positions.len(),
        nodes: shape.nodes.len(),
        joints: shape.joints.len(),
        morph_targets: shape.morph_targets.len(),
        clips: shape.clips.iter().map(ClipInfo::of).collect(),
    }
}

fn environment_details(environment: Environment) -> Details {
    let map = &environment.map;
    let brightest = map.texels.iter().fold([0.0f32; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
    Details::Environment { size: [map.width, map.height], brightest, name: environment.name }
}

fn rows_details(meta: &sparse_transfer::Meta) -> Details {
    Details::SparseTransfer {
        rows: meta.vertices,
        terms: meta.terms(),
        face_size: meta.face_size,
        bounces: meta.bounces,
        channels: meta.channels(),
        wide_terms: meta.blocks.iter().filter(|b| b.wide).map(|b| b.terms).sum(),
        rays_per_texel: meta.rays_per_texel,
        bytes_of_dense_matrix: u64::from(meta.vertices) * (meta.coefficients() * meta.channels() * 4) as u64,
    }
}

fn shadows_details(shadows: SphereShadows) -> Details {
    Details::SphereShadows {
        receivers: shadows.rows.len(),
        exact_receivers: shadows.rows.iter().filter(|row| **row != NO_ROW).count(),
        terms: shadows.meta.terms,
        second_level: shadows.meta.second_level,
        rows: shadows.normals.len(),
        grid_rows: NODES,
        objects: shadows.meta.objects,
    }
}

fn scene_details(scene: StoredScene) -> Details {
    Details::Scene {
        size: scene.meta.size,
        camera: scene.meta.camera,
        vertices: scene.positions.len(),
        triangles: scene.triangles.len(),
        objects: scene.meta.objects.into_iter().map(|o| o.name).collect(),
        materials: scene.meta.materials,
        name: scene.meta.name,
    }
}

fn animation_details(animation: Animation) -> Details {
    let Animation { name, duration_s, looping, tracks } = animation;
    let tracks = tracks.iter().map(|t| TrackInfo { leaf: t.leaf.join("."), keys: t.times_s.len() }).collect();
    Details::Animation { name, duration_s, looping, tracks }
}

fn basis_details(basis: &BrdfBasis) -> Details {
    let range = [basis.parameters.first(), basis.parameters.last()].map(|s| s.copied().unwrap_or(f32::NAN));
    Details::BrdfBasis {
        bases: basis.bases(),
        model: basis.functions.model(),
        nodes: basis.parameters.len(),
        range,
        shared_diffuse: basis.meta.shared_diffuse,
        error_at_samples: basis.meta.error_at_samples,
        error_between: basis.meta.error_between,
    }
}

fn images_details(head: &Head) -> Details {
    let layout = head.layout();
    let rgb_images = layout.slots.iter().filter(|s| s.rgb).count();
    let fragments_of = |class: usize| head.class.iter().filter(|c| usize::from(**c) == class).count();
    let materials = head.meta.materials.iter().cloned().map(Some).chain([None]);
    Details::TransferImages {
        size: head.meta.size,
        bases: head.meta.bases,
        chromaticity: head.meta.chromaticity,
        samples: head.meta.samples,
        seed: head.meta.seed,
        rgb_images,
        single_channel_images: layout.slots.len() - rgb_images,
        fragments: head.pixel.len(),
        classes: materials.enumerate().map(|(class, material)| ClassInfo { material, fragments: fragments_of(class) }).collect(),
    }
}
