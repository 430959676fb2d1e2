//! Contenders take turns, so that what else goes on in the machine hits all alike.

use std::time::Instant;

/// Runs `f` with a number of threads.
pub(crate) fn with_threads<R: Send>(threads: usize, f: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(f)
}

/// Measures the works of a case and prints a row for each.
pub(crate) struct Turns<'a> {
    case: &'a str,
    threads: usize,
    rounds: usize,
}

impl<'a> Turns<'a> {
    /// Small cases take more rounds.
    pub(crate) fn new(case: &'a str, threads: usize, count: usize) -> Self {
        Turns { case, threads, rounds: (5_000_000 / count.max(1)).clamp(7, 101) }
    }

    /// Prints the median time of each contender; those after the first as a multiple of it, which is the median of the ratios of
    /// turns next to each other. Returns the medians, ms.
    pub(crate) fn take(&mut self, work: &str, contenders: &mut [&mut (dyn FnMut() + Send)]) -> Vec<f64> {
        let mut times = vec![Vec::new(); contenders.len()];
        for round in 0..=self.rounds {
            for (times, contender) in times.iter_mut().zip(&mut *contenders) {
                let start = Instant::now();
                contender();
                // The first round fills caches.
                if round > 0 {
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        let ratios =
            times.iter().map(|t| median(t.iter().zip(&times[0]).map(|(t, first)| t / first).collect()));
        let ratios: Vec<f64> = ratios.collect();
        let medians: Vec<f64> = times.into_iter().map(median).collect();
        self.print(work, &medians, &ratios);
        medians
    }

    /// Prints the sums of several works.
    pub(crate) fn sum(&self, work: &str, parts: &[Vec<f64>]) {
        let sums: Vec<f64> = (0..parts[0].len()).map(|i| parts.iter().map(|part| part[i]).sum()).collect();
        let ratios: Vec<f64> = sums.iter().map(|sum| sum / sums[0]).collect();
        self.print(work, &sums, &ratios);
    }

    fn print(&self, work: &str, medians: &[f64], ratios: &[f64]) {
        let mut row = format!("| {} | {} | {work} | {:.3} |", self.case, self.threads, medians[0]);
        for (time, ratio) in medians.iter().zip(ratios).skip(1) {
            row += &format!(" {time:.3} (× {ratio:.2}) |");
        }
        println!("{row}{}", " |".repeat(3_usize.saturating_sub(medians.len())));
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}
