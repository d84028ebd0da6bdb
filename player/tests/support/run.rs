//! Runs of the binary, and what is expected of them.

use std::path::Path;
use std::process::{Child, Command, Output};

/// Runs without a display.
pub fn player(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_player"));
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    command.args(arguments).output().unwrap()
}

/// Waits until a player catches interrupts.
#[cfg(target_os = "linux")]
#[track_caller]
pub fn wait_until_it_listens(child: &mut Child) {
    let listens = |child: &Child| {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        let caught = u64::from_str_radix(caught.trim(), 16).ok()?;
        // Signal n is bit n - 1; SIGINT is 2.
        Some(()).filter(|()| caught & 1 << 1 != 0)
    };
    while listens(child).is_none() {
        assert!(child.try_wait().unwrap().is_none(), "it ended too soon");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

pub fn gpu_there() -> bool {
    crate::support::gpu_there(|| relume_player::gpu::list().map(|_| ()).map_err(|e| e.to_string()))
}

/// Runs with `--headless` on `folder`; in `arguments`, `@` stands for the folder too.
pub fn headless(folder: &Path, arguments: &[&str]) -> Output {
    let folder = folder.to_str().unwrap();
    let arguments: Vec<String> = arguments.iter().map(|a| a.replace('@', folder)).collect();
    player(
        &[&[folder, "--headless"], arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice()]
            .concat(),
    )
}

#[track_caller]
pub fn expect_error(output: &Output, code: i32, part: &str) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(
        stderr.starts_with("error: ") && stderr.lines().count() == 1 && stderr.contains(part),
        "{stderr}"
    );
}

#[track_caller]
pub fn expect_success(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

pub fn stats(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}
