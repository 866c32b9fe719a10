//! `biped latency`: cost and delay of the link between two processes, compared with the limits of the host.
//!
//! | what | where |
//! |---|---|
//! | round trips: our ports, sockets, and the limits in shared memory | [`carrier`], [`bare`], [`lines`], [`sockets`] |
//! | the parts of a round trip over our ports | [`breakdown`] |
//! | the walk in lockstep | [`walk`] |
//! | runs at 1 kHz of the clock, and the host's floor | [`paced`], [`floor`], [`watch`] |
//! | both ends of a connection | [`initiator`], [`second_process`], [`serve`] |
//! | histograms, tables, drawings | [`spread`], [`results`], [`draw`], [`page`] |
//! | the machine and its other load | [`host`] |

mod bare;
mod bench;
mod breakdown;
mod carrier;
mod draw;
mod floor;
mod host;
mod initiator;
mod lines;
mod paced;
mod page;
mod results;
mod second_process;
mod serve;
mod sockets;
mod spread;
mod terms;
mod walk;
mod watch;

pub use serve::{PeerArgs, serve as peer};

use bench::{Bench, Plan};
use carrier::Carrier;
use clap::Args;
use host::Host;
use lines::Wake;
use messages::port::Waiting;
use results::Results;
use sessions::realtime::{RealtimeArgs, pin_to_nth};
use shared::exit::Failure;
use shared::output::{print_text, write_atomically, write_failure};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Arguments of `biped latency`.
#[derive(Args)]
pub struct LatencyArgs {
    /// Write the numbers as `latency.json`, the drawings and the page into this folder
    #[arg(long, value_name = "DIR", default_value = "out/latency")]
    out: PathBuf,
    /// Few samples of each measurement: takes seconds instead of a minute
    #[arg(long)]
    quick: bool,
    #[arg(from_global)]
    quiet: bool,
    /// Real-time settings of the runs that the clock paces
    #[command(flatten)]
    system: RealtimeArgs,
}

/// Measures, prints and draws everything.
///
/// # Errors
/// A link that breaks, a folder that cannot be written, or Ctrl-C.
pub fn run(args: &LatencyArgs, stop: &AtomicBool) -> Result<(), Failure> {
    page::prepare(&args.out)?;
    let failed = |error| write_failure(&args.out, &error);
    let mut results = Results::new(Host::watch());
    let mut bench = Bench::start(if args.quick { Plan::QUICK } else { Plan::FULL }, args.quiet, stop)?;
    bench.expect(bench.plan.rounds as usize * Carrier::ALL.len() + walk::count() + 2);
    breakdown::alone(&mut results)?;
    bench::on_new_thread(|| {
        pin_to_nth(0); // the other process uses another processor, so that all links are compared over the same distance
        carrier::measure(&mut bench, &mut results)?;
        walk::measure(&mut bench, &mut results)
    })?;
    bench::on_new_thread(|| paced::link(&mut bench, &mut results, args.system))?;
    paced::walk(&mut bench, &mut results, args.system)?;
    bench.counter.finish();
    drop(bench);
    results.host.finish();
    breakdown::parts(&mut results);
    judge(&mut results);
    write_atomically(&args.out.join("latency.json"), &results.json()?).map_err(failed)?;
    page::write(&args.out, &results).map_err(failed)?;
    print_text(format_args!(
        "{results}\nfigures in {}, drawn in latency.html beside it\n",
        args.out.join("latency.json").display()
    ));
    Ok(())
}

/// The targets. Absolute times depend on the host, so targets are ratios to the host's limits.
fn judge(results: &mut Results) {
    let trip = |carrier: Carrier| (carrier.name(), "round trip");
    let spinning = [trip(Carrier::Port(Waiting::Spin)), trip(Carrier::Lines(Wake::Spin))];
    let blocking = [trip(Carrier::Port(Waiting::Event)), trip(Carrier::Lines(Wake::Futex))];
    results.judge("round trip / raw shared memory, medians, spinning", spinning, 0.5, 5.5);
    results.judge("round trip / futex hand-over, medians, blocking", blocking, 0.5, 1.6);
    results.judge("wake / host floor, 99 %, no plant", [(paced::LINK, "wake"), (paced::LINK, paced::FLOOR)], 0.99, 1.2);
    results.judge("wake / host floor, 99 %, walk", [(paced::WALK, "wake"), (paced::WALK, paced::FLOOR)], 0.99, 1.2);
}
