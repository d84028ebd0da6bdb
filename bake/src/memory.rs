//! How much memory a bake may take.

use crate::error::{ALLOWED, BakeError, Result};

/// What a bake may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryLimit {
    /// What the machine has free when it is asked.
    Free,
    /// So many bytes.
    Bytes(u64),
}

/// What a bake will take, as far as is known before it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryNeed {
    /// At most.
    pub bytes: u64,
    /// What makes it less.
    pub remedy: &'static str,
}

impl MemoryLimit {
    /// Fails if `need` is more than this.
    ///
    /// # Errors
    /// [`BakeError::Memory`].
    pub fn expect(self, need: MemoryNeed) -> Result<()> {
        let (most, of_what) = match self {
            Self::Bytes(bytes) => (Some(bytes), ALLOWED),
            Self::Free => (available_bytes(), "free"),
        };
        // Something has to stay for everybody else.
        let usable = most.map(|bytes| if self == Self::Free { bytes / 10 * 9 } else { bytes });
        match (most, usable) {
            (Some(most), Some(usable)) if need.bytes > usable => Err(BakeError::Memory {
                needed_mib: need.bytes >> 20,
                available_mib: most >> 20,
                of_what,
                remedy: need.remedy,
            }),
            _ => Ok(()),
        }
    }
}

/// Memory that the system, the container that this runs in, or the user's limits would give out now; `None`
/// where nobody says.
fn available_bytes() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let free = read("/proc/meminfo").as_deref().and_then(free_of_meminfo);
    let of_container = read("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    let of_user = read("/proc/self/limits").as_deref().and_then(address_space);
    [free, of_container, of_user].into_iter().flatten().min()
}

fn free_of_meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kib| kib << 10)
}

/// The soft limit, `ulimit -v`.
fn address_space(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says_is_understood() {
        assert_eq!(free_of_meminfo("MemTotal:       100 kB\nMemAvailable:   24563 kB\n"), Some(24563 << 10));
        assert_eq!(
            address_space(
                "Limit  Soft  Hard\nMax address space         6144000000           unlimited            bytes\n"
            ),
            Some(6_144_000_000)
        );
        assert_eq!(
            address_space("Max address space         unlimited            unlimited            bytes\n"),
            None
        );
    }

    #[test]
    fn a_need_above_the_limit_is_refused_with_both_numbers() {
        let need = |bytes| MemoryNeed { bytes, remedy: "lower --size" };
        MemoryLimit::Bytes(1 << 30).expect(need(1 << 30)).unwrap();
        let error = MemoryLimit::Bytes(1 << 30).expect(need((3 << 30) + 1)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "this bake needs about 3072 MiB of memory and 1024 MiB are allowed by --memory; lower --size"
        );
        assert_eq!(error.exit_code(), 2, "another bake has to be asked for");
        MemoryLimit::Free.expect(need(1)).unwrap();
        if cfg!(target_os = "linux") {
            let error = MemoryLimit::Free.expect(need(u64::MAX)).unwrap_err();
            assert!(error.to_string().contains("MiB are free; lower --size"), "{error}");
            assert_eq!(error.exit_code(), 1, "another day the machine has more to give");
        }
    }
}
