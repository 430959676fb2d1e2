//! What this process has used, as Linux tells it. Other systems tell nothing here.

use std::fs;

/// The most memory that the process has had at once (`VmHWM`) since it began or since [`forget_peak`], bytes.
pub(crate) fn peak_memory() -> Option<u64> {
    parse_peak(&fs::read_to_string("/proc/self/status").ok()?)
}

fn parse_peak(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

/// From now on [`peak_memory`] is the most since now. Whether the system can do that.
pub(crate) fn forget_peak() -> bool {
    // See proc_pid_clear_refs(5).
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// Processor time of all threads that live, milliseconds. Unlike the clock on the wall it does not count what
/// neighbours on the machine take.
pub(crate) fn cpu_ms() -> Option<f64> {
    let tasks = fs::read_dir("/proc/self/task").ok()?;
    let time = |task: fs::DirEntry| {
        let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
        // The first number is the time on a processor in nanoseconds.
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    let times: Vec<f64> = tasks.filter_map(Result::ok).filter_map(time).collect();
    (!times.is_empty()).then(|| 1e-6 * times.iter().sum::<f64>())
}

/// Name of the processor and number of threads that it runs at once.
pub(crate) fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    format!("{}, {threads} hardware threads", name.map_or("unknown processor", |(_, name)| name.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_memory_is_read_in_bytes() {
        assert_eq!(parse_peak("Name:\tx\nVmHWM:\t    1234 kB\nVmRSS:\t 5 kB\n"), Some(1234 * 1024));
        assert_eq!(parse_peak("Name:\tx\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn peak_memory_grows_with_what_is_touched() {
        let before = peak_memory().expect("Linux tells");
        // Other tests may have had much and given it back: only what is above all of that raises the peak.
        let block = std::hint::black_box(vec![1u8; before as usize + (64 << 20)]);
        let grown = peak_memory().expect("Linux tells") - before;
        assert!(grown >= 32 << 20, "{grown} after {} bytes", block.len());
        drop(block);
        if forget_peak() {
            let now = peak_memory().expect("Linux tells");
            assert!(now < before + grown - (32 << 20), "{now}");
        }
    }
}
