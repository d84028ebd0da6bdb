//! Finding and choosing an adapter.

use crate::error::{Error, Result};
use relume_playback::methods::METHODS;
use wgpu::{Adapter, AdapterInfo, DeviceType, Instance, InstanceDescriptor, Surface};

/// The name that asks for sums on the CPU.
pub(super) const CPU: &str = "cpu";

/// Whether `name` asks for sums on the CPU.
pub(super) fn is_cpu(name: Option<&str>) -> bool {
    name.is_some_and(|name| name.eq_ignore_ascii_case(CPU))
}

/// Every adapter that can show on `surface`, if one is given, the most promising first; never empty.
fn all(instance: &Instance, surface: Option<&Surface<'_>>) -> Result<Vec<Adapter>> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.retain(|adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface)));
    if adapters.is_empty() {
        return Err(Error::Failed(
            "no GPU adapter; install mesa-vulkan-drivers for a software one".to_owned(),
        ));
    }
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    Ok(adapters)
}

/// The adapter of `instance` that `info` describes, if it is there.
pub(super) fn same_as(instance: &Instance, info: &AdapterInfo) -> Option<Adapter> {
    let of = |info: &AdapterInfo| {
        (info.name.clone(), info.backend, info.vendor, info.device, info.device_pci_bus_id.clone())
    };
    all(instance, None).ok()?.into_iter().find(|adapter| of(&adapter.get_info()) == of(info))
}

fn rank(kind: DeviceType) -> u32 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

fn describe(info: &AdapterInfo) -> String {
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => "discrete GPU",
        DeviceType::IntegratedGpu => "integrated GPU",
        DeviceType::VirtualGpu => "virtual GPU",
        DeviceType::Other => "other",
        DeviceType::Cpu => "CPU",
    };
    format!("{} [{kind}, {}]", info.name, info.backend)
}

/// The methods that can do their sums on the CPU.
pub(super) fn able_on_cpu() -> String {
    let able = METHODS.iter().filter(|method| method.on_cpu).map(|method| method.card.name);
    able.collect::<Vec<_>>().join(", ")
}

/// One line per adapter, in order of preference, and one for the CPU's own work, if there is a software
/// adapter to draw.
pub fn list() -> Result<Vec<String>> {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    Ok(described(&all(&instance, None)?))
}

fn described(adapters: &[Adapter]) -> Vec<String> {
    let infos: Vec<AdapterInfo> = adapters.iter().map(Adapter::get_info).collect();
    let software = infos.iter().find(|info| info.device_type == DeviceType::Cpu);
    let cpu = software
        .map(|info| format!("{CPU} [radiance of {} on all cores, {} draws]", able_on_cpu(), info.name));
    infos.iter().map(describe).chain(cpu).collect()
}

/// The adapter whose name contains `name` in any case, or the most promising one; for [`CPU`] the software
/// adapter.
pub(super) fn choose(
    instance: &Instance,
    surface: Option<&Surface<'_>>,
    name: Option<&str>,
) -> Result<Adapter> {
    let adapters = all(instance, surface)?;
    if is_cpu(name) {
        let software = adapters.into_iter().find(|adapter| adapter.get_info().device_type == DeviceType::Cpu);
        return software.ok_or_else(|| {
            Error::Failed(
                "--adapter cpu has nothing to draw with; install mesa-vulkan-drivers for a software adapter"
                    .to_owned(),
            )
        });
    }
    let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
    let index = pick(&names, name).map_err(|reason| {
        Error::Usage(format!("{reason}; this machine has: {}", described(&adapters).join("; ")))
    })?;
    adapters.into_iter().nth(index).ok_or_else(|| Error::Failed("the GPU adapter has gone".to_owned()))
}

/// Index of the adapter asked for. Equal names are one device behind several drivers, or twins: then the
/// first will do.
fn pick(names: &[String], wanted: Option<&str>) -> std::result::Result<usize, String> {
    let Some(wanted) = wanted else { return Ok(0) };
    let wanted_lower = wanted.to_lowercase();
    let mut found = names.iter().enumerate().filter(|(_, name)| name.to_lowercase().contains(&wanted_lower));
    match found.next() {
        None => Err(format!("no GPU adapter is called `{wanted}`")),
        Some((_, first)) if found.any(|(_, other)| other != first) => {
            Err(format!("several GPU adapters are called `{wanted}`"))
        }
        Some((index, _)) => Ok(index),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_match_in_part_and_in_any_case() {
        let names =
            ["GeForce RTX 4070", "Radeon 780M", "llvmpipe (LLVM 15)", "Radeon 780M"].map(str::to_owned);
        assert_eq!(pick(&names, None), Ok(0));
        assert_eq!(pick(&names, Some("LLVM")), Ok(2));
        assert_eq!(pick(&names, Some("radeon")), Ok(1), "twins");
        assert!(pick(&names, Some("r")).unwrap_err().starts_with("several"));
        assert!(pick(&names, Some("voodoo")).unwrap_err().starts_with("no GPU"));
    }

    #[test]
    fn hardware_is_preferred_to_software() {
        let best_first = [
            DeviceType::DiscreteGpu,
            DeviceType::IntegratedGpu,
            DeviceType::VirtualGpu,
            DeviceType::Other,
            DeviceType::Cpu,
        ];
        assert!(best_first.windows(2).all(|w| rank(w[0]) < rank(w[1])));
    }
}
