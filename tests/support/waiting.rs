//! Waiting for processes: for what is expected to be seen, with a limit that no busy machine reaches, and
//! never for a time.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(600);
/// From one look to the next.
const PAUSE: Duration = Duration::from_millis(2);

/// Waits until `look` finds something while `child` runs.
#[track_caller]
pub fn wait_for<T>(child: &mut Child, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        if let Some(status) = child.try_wait().unwrap() {
            panic!("waited for {what}, but the process ended: {status}");
        }
        assert!(began.elapsed() < PATIENCE, "waited for {what} in vain");
        std::thread::sleep(PAUSE);
    }
}

/// Lets `child` work until it has had `seconds` of processor time, or has ended. Returns how much it has had;
/// however busy the machine, it has got as far by then.
#[cfg(target_os = "linux")]
pub fn let_work(child: &mut Child, seconds: f64) -> f64 {
    let mut had = 0.0;
    while child.try_wait().unwrap().is_none() {
        had = processor_s(child).unwrap_or(had);
        if had >= seconds {
            break;
        }
        std::thread::sleep(PAUSE);
    }
    had
}

/// Processor time of all threads of a process, in seconds.
#[cfg(target_os = "linux")]
fn processor_s(child: &Child) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).ok()?;
    // Behind the name, which may hold anything: the state is field 3, times in user and system mode are
    // fields 14 and 15, in hundredths.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let hundredths = |field: usize| fields.get(field - 3)?.parse::<f64>().ok();
    Some((hundredths(14)? + hundredths(15)?) / 100.0)
}

/// Does what Ctrl-C does.
#[track_caller]
pub fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}
