//! Files that are wrong, or strange, or both: none may end in a panic, take long, or take much memory.
//!
//! `cargo run --release --example fuzz -- check COUNT [FIRST [THREADS]]` reads COUNT (a million unless given) changed networks as
//! `pennate check` does, from seed FIRST on; `-- solve` solves networks whose numbers were changed, each within a budget.
//! What is wrong is listed by its seed, and ends the program with status 1; `-- show SEED` prints the file of a seed, and
//! `-- show SEED solve` the one to be solved.

#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{LazyLock, Mutex};
use std::time::{Duration, Instant};

use pennate_testing::fuzz::corpus::Corpus;
use pennate_testing::fuzz::mutate::{Case, case, varied};
use pennate_testing::fuzz::trial;

/// Time on a processor for one file to be read and checked.
const SLOW: Duration = Duration::from_secs(1);
/// The same where it is solved.
const SLOW_SOLVE: Duration = Duration::from_secs(20);
/// Time after which nothing more is waited for.
const HANGS: Duration = Duration::from_secs(100);
/// Memory for one file, bytes.
const LARGE: usize = 1 << 30;

/// The heap, counting what each thread has of it.
struct Counting;

thread_local! {
    static NOW: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
}

fn count(added: usize, removed: usize) {
    // What another thread allocated may end here.
    let now = NOW.get().saturating_add(added).saturating_sub(removed);
    NOW.set(now);
    PEAK.set(PEAK.get().max(now));
}

// SAFETY: everything is left to the heap; the counters are cells of the thread, made without allocation.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, layout.size());
        unsafe { Heap.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(0, layout.size());
        unsafe { Heap.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What all threads share.
struct Run {
    corpus: Corpus,
    solve: bool,
    next: AtomicU64,
    end: u64,
    /// Seed and begin, in milliseconds, of what each thread is busy with.
    busy: Vec<[AtomicU64; 2]>,
    begin: Instant,
    total: Mutex<Total>,
}

#[derive(Default)]
struct Total {
    outcomes: BTreeMap<String, u64>,
    wrong: u64,
    slowest: (Duration, u64),
    largest: (usize, u64),
    bytes: u64,
}

fn main() -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u64| arguments.get(at).map_or(default, |text| text.parse().expect("a number"));
    let corpus = Corpus::read(Path::new(env!("CARGO_MANIFEST_DIR")));
    let mode = arguments.first().map_or("check", String::as_str);
    if mode == "show" {
        let to_solve = arguments.get(2).is_some_and(|text| text == "solve");
        let case = if to_solve { varied(&corpus, number(1, 0)) } else { case(&corpus, number(1, 0)) };
        std::io::stdout().write_all(&case.bytes).expect("standard output");
        return std::process::ExitCode::SUCCESS;
    }
    std::panic::set_hook(Box::new(|_| {}));
    let first = number(2, 0);
    let threads = number(3, std::thread::available_parallelism().map_or(1, |count| count.get() as u64));
    let run = Run {
        corpus,
        solve: mode == "solve",
        next: AtomicU64::new(first),
        end: first + number(1, 1_000_000),
        busy: (0..threads).map(|_| [AtomicU64::new(0), AtomicU64::new(0)]).collect(),
        begin: Instant::now(),
        total: Mutex::default(),
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = run.busy.iter().map(|busy| scope.spawn(|| work(&run, busy))).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            std::thread::sleep(Duration::from_millis(200));
            let now = run.begin.elapsed().as_millis() as u64;
            for [seed, begin] in &run.busy {
                if now.saturating_sub(begin.load(Relaxed)) > HANGS.as_millis() as u64 && begin.load(Relaxed) > 0 {
                    println!("seed {}: hangs", seed.load(Relaxed));
                    std::process::exit(1);
                }
            }
        }
    });
    let total = run.total.into_inner().expect("no panic while it was held");
    let (executions, time) = (run.end - first, run.begin.elapsed());
    println!("| what came of it | files |\n|---|---:|");
    total.outcomes.iter().for_each(|(what, count)| println!("| {what} | {count} |"));
    println!(
        "\n{executions} files of {:.0} bytes each in {time:.0?}, {:.0} a second; slowest {:.2?} (seed {}), largest {:.0} MB (seed {})",
        total.bytes as f64 / executions as f64,
        executions as f64 / time.as_secs_f64(),
        total.slowest.0,
        total.slowest.1,
        total.largest.0 as f64 * 1e-6,
        total.largest.1
    );
    std::process::ExitCode::from(u8::from(total.wrong > 0))
}

fn work(run: &Run, [busy, begin]: &[AtomicU64; 2]) {
    loop {
        let seed = run.next.fetch_add(1, Relaxed);
        if seed >= run.end {
            begin.store(0, Relaxed);
            return;
        }
        busy.store(seed, Relaxed);
        let case = if run.solve { varied(&run.corpus, seed) } else { case(&run.corpus, seed) };
        let limit = if run.solve { SLOW_SOLVE } else { SLOW };
        begin.store(run.begin.elapsed().as_millis().max(1) as u64, Relaxed);
        let start = spent();
        let before = NOW.get();
        PEAK.set(before);
        let outcome = attempt(run.solve, &case);
        let memory = PEAK.get() - before;
        let time = spent().saturating_sub(start);
        let wrong = match &outcome {
            Err(what) => Some(what.clone()),
            Ok(_) if time > limit => Some(format!("takes {time:.1?}")),
            Ok(_) if memory > LARGE => Some(format!("takes {} MB", memory >> 20)),
            Ok(_) => None,
        };
        let mut total = run.total.lock().expect("no panic while it was held");
        if let Some(what) = &wrong {
            println!("seed {seed}: {what}");
            total.wrong += 1;
        }
        *total.outcomes.entry(outcome.map_or_else(|_| "wrong".to_owned(), str::to_owned)).or_default() += 1;
        total.slowest = total.slowest.max((time, seed));
        total.largest = total.largest.max((memory, seed));
        total.bytes += case.bytes.len() as u64;
    }
}

/// Time that the thread has had a processor, where the system tells it; the time of day elsewhere.
fn spent() -> Duration {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split_whitespace().next()?.parse().ok());
    nanoseconds.map_or_else(|| BEGIN.elapsed(), Duration::from_nanos)
}

fn attempt(solve: bool, case: &Case) -> Result<&'static str, String> {
    let tried = std::panic::catch_unwind(|| match solve {
        true => trial::solve(case.name, &case.bytes),
        false => trial::check(case.name, &case.bytes),
    });
    tried.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        Err(format!("panics: {}", text.unwrap_or("without a word")))
    })
}
