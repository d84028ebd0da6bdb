//! glTF animations as clips. What an animation does to nodes outside the scene, or to morph targets of meshes
//! that are not read, is left out.

use super::gltf_buffers::Buffers;
use super::gltf_file::GltfFile;
use super::gltf_nodes::Placement;
use super::tidy_name;
use crate::numbering::{listed, numbered};
use gltf::Animation;
use gltf::animation::{Interpolation as GltfInterpolation, Property as GltfProperty, Sampler};
use gltf::json::validation::Checked;
use relume_formats::shape::{Clip, Interpolation, MAX_CLIP_KEYS, MAX_CLIPS, Property, Track};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;

/// Every animation of `file` that moves anything; `targets_of_node` are the morph targets of nodes, by their
/// number in the file. Names that repeat are numbered, which is added to `warnings`.
pub(super) fn read(
    file: &GltfFile,
    nodes: &Placement<'_>,
    targets_of_node: &HashMap<usize, Vec<u32>>,
    place: &Place,
    warnings: &mut Vec<String>,
) -> Result<Vec<Clip>> {
    if file.document.animations().count() > MAX_CLIPS {
        return Err(Error::invalid(place, format!("more than {MAX_CLIPS} animations; remove some")));
    }
    let mut reader = Reader { file, nodes, targets_of_node, keys: 0 };
    let clips = file
        .document
        .animations()
        .map(|animation| reader.clip(&animation, place))
        .collect::<Result<Vec<_>>>()?;
    let mut clips: Vec<Clip> = clips.into_iter().filter(|clip| !clip.tracks.is_empty()).collect();
    let (names, changed) = numbered(clips.iter().map(|clip| clip.name.clone()));
    if !changed.is_empty() {
        warnings.push(format!("{place}: names of animations repeat; numbered {}", listed(&changed)));
    }
    clips.iter_mut().zip(names).for_each(|(clip, name)| clip.name = name);
    Ok(clips)
}

struct Reader<'a> {
    file: &'a GltfFile,
    nodes: &'a Placement<'a>,
    targets_of_node: &'a HashMap<usize, Vec<u32>>,
    /// Those of all tracks so far.
    keys: usize,
}

impl Reader<'_> {
    fn clip(&mut self, animation: &Animation<'_>, place: &Place) -> Result<Clip> {
        let named = animation.name().map(tidy_name).filter(|name| !name.is_empty());
        let name = named.unwrap_or_else(|| format!("clip-{}", animation.index()));
        let mut tracks = Vec::new();
        for (channel, json) in
            self.file.document.as_json().animations[animation.index()].channels.iter().enumerate()
        {
            let place = place.part(format!("animation {}, channel {channel}", animation.index()));
            let (node, sampler) = (json.target.node.value(), animation.samplers().nth(json.sampler.value()));
            // The crate checks all of the file but this, and panics on it.
            let (Checked::Valid(property), Some(sampler)) =
                (json.target.path, sampler.filter(|_| node < self.nodes.file_nodes()))
            else {
                return Err(Error::invalid(
                    &place,
                    "names a node or property that is not there; export the file again",
                ));
            };
            let properties = self.properties(node, property);
            if !properties.is_empty() {
                self.append(&properties, &sampler, &mut tracks, &place)?;
            }
        }
        let duration_s =
            tracks.iter().filter_map(|track: &Track| track.times_s.last()).fold(0.0, |a: f32, b| a.max(*b));
        Ok(Clip { name, duration_s, tracks })
    }

    /// What a channel sets: one property, or the weights of all morph targets of a node; none that matters if
    /// empty.
    fn properties(&self, node: usize, property: GltfProperty) -> Vec<Property> {
        let of_node = |make: fn(u32) -> Property| self.nodes.index_of(node).map(make).into_iter().collect();
        match property {
            GltfProperty::Translation => of_node(Property::Translation),
            GltfProperty::Rotation => of_node(Property::Rotation),
            GltfProperty::Scale => of_node(Property::Scale),
            GltfProperty::MorphTargetWeights => self
                .targets_of_node
                .get(&node)
                .into_iter()
                .flatten()
                .map(|target| Property::MorphWeight(*target))
                .collect(),
        }
    }

    /// Appends a track for each of `properties`, which share the keys of `sampler`.
    fn append(
        &mut self,
        properties: &[Property],
        sampler: &Sampler<'_>,
        tracks: &mut Vec<Track>,
        place: &Place,
    ) -> Result<()> {
        let (input, output) = (sampler.input(), sampler.output());
        // A track without keys is refused later, but takes memory now.
        self.keys = self.keys.saturating_add(input.count().max(1).saturating_mul(properties.len()));
        if self.keys > MAX_CLIP_KEYS {
            return Err(Error::invalid(
                place,
                format!("more than {MAX_CLIP_KEYS} keys in all animations; simplify them"),
            ));
        }
        let interpolation = match sampler.interpolation() {
            GltfInterpolation::Step => Interpolation::Step,
            GltfInterpolation::Linear => Interpolation::Linear,
            GltfInterpolation::CubicSpline => Interpolation::CubicSpline,
        };
        // A key's entries: its value, or its two tangents around it; of each, one per morph target.
        let entries = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let expected = input.count() * entries * properties.len();
        if output.count() != expected {
            let reason = format!(
                "{} values where its {} keys need {expected}; export the file again",
                output.count(),
                input.count()
            );
            return Err(Error::invalid(place, reason));
        }
        let times_s = self.file.buffers.times(&input, place)?;
        let values = values(properties, &output, &self.file.buffers, place)?;
        for (k, property) in properties.iter().enumerate() {
            let of_property = values.chunks(property.components()).skip(k).step_by(properties.len());
            let values = of_property.flatten().copied().collect();
            tracks.push(Track { property: *property, interpolation, times_s: times_s.clone(), values });
        }
        Ok(())
    }
}

fn values(
    properties: &[Property],
    output: &gltf::Accessor<'_>,
    buffers: &Buffers,
    place: &Place,
) -> Result<Vec<f32>> {
    match properties.first() {
        Some(Property::Rotation(_)) => Ok(buffers.quaternions(output, place)?.into_flattened()),
        Some(Property::MorphWeight(_)) => buffers.morph_weights(output, place),
        _ => Ok(buffers.exact_vectors(output, place)?.into_flattened()),
    }
}
