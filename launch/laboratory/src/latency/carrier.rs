//! Every transport of a message between two processes and back, all measured in the same way.

use super::bare;
use super::bench::Bench;
use super::initiator::Initiator;
use super::lines::Wake;
use super::results::Results;
use super::second_process::Order;
use super::sockets::{Meeting, SIZE, Socket};
use super::spread::Spread;
use super::terms::null_plant;
use messages::clock::now_ns;
use messages::port::Waiting;
use messages::wire::{Sensors, Stamp};
use sessions::realtime::RealtimeArgs;
use shared::exit::Failure;

/// A transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// Two cache lines: the lower limits.
    Lines(Wake),
    /// Our messages without stamps, check sums and checks, spinning, over iceoryx2 alone or our ports.
    Bare { ours: bool },
    /// Our own ports.
    Port(Waiting),
    /// A Unix stream.
    Unix { spins: bool },
    /// UDP over loopback.
    Udp { spins: bool },
}

impl Carrier {
    /// All carriers, each with its name in tables. Carriers that are compared are neighbours in this list, so they are measured one
    /// right after the other.
    pub const ALL: [(Carrier, &str); 11] = [
        (Carrier::Lines(Wake::Spin), "raw shared memory, spin"),
        (Carrier::Bare { ours: false }, "iceoryx2 alone, spin"),
        (Carrier::Bare { ours: true }, "pub/sub unsealed, spin"),
        (Carrier::Port(Waiting::Spin), "pub/sub, spin"),
        (Carrier::Port(Waiting::Hybrid), "pub/sub, hybrid"),
        (Carrier::Unix { spins: true }, "Unix socket, spin"),
        (Carrier::Udp { spins: true }, "UDP, spin"),
        (Carrier::Lines(Wake::Futex), "futex hand-over"),
        (Carrier::Port(Waiting::Event), "pub/sub, event"),
        (Carrier::Unix { spins: false }, "Unix socket, blocking"),
        (Carrier::Udp { spins: false }, "UDP, blocking"),
    ];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(carrier, _)| *carrier == self).map_or("unknown", |(_, name)| name)
    }

    /// Whether every wait sleeps.
    pub fn sleeps(self) -> bool {
        use Carrier::{Lines, Port, Udp, Unix};
        matches!(self, Lines(Wake::Futex) | Port(Waiting::Event) | Unix { spins: false } | Udp { spins: false })
    }
}

/// Round trips over every carrier in turn. Each starts when the previous one has ended: every stall falls into one of them, and none
/// is hidden.
///
/// # Errors
/// A link that breaks, or Ctrl-C.
pub fn measure(bench: &mut Bench, results: &mut Results) -> Result<(), Failure> {
    bench.begin_group("round trips without a plant");
    for _ in 0..bench.plan.rounds {
        for (carrier, name) in Carrier::ALL {
            bench.step(name)?;
            let count = bench.plan.trips[usize::from(carrier.sleeps())];
            turn(bench, results, carrier, count)?;
        }
    }
    Ok(())
}

fn turn(bench: &mut Bench, results: &mut Results, carrier: Carrier, count: u32) -> Result<(), Failure> {
    match carrier {
        Carrier::Lines(wake) => {
            let (lines, number) = (bench.lines, bench.number);
            lines.clear();
            bench.peer.order(&Order::Lines { number, wake })?;
            let spread = trips(count, bench.plan.turn_ns, |seq| lines.ask(seq, wake))?;
            lines.end(wake);
            results.put(carrier.name(), "round trip", &spread);
            Ok(())
        }
        Carrier::Unix { spins } => {
            let name = format!("biped-latency-{}-{:x}", std::process::id(), now_ns());
            let meeting = Meeting::unix(&name)?;
            bench.peer.order(&Order::Unix { name, spins })?;
            sockets(bench, results, carrier, meeting.accept(spins)?)
        }
        Carrier::Udp { spins } => {
            let (meeting, port) = Meeting::udp()?;
            bench.peer.order(&Order::Udp { port, spins })?;
            sockets(bench, results, carrier, meeting.accept(spins)?)
        }
        Carrier::Bare { ours } => {
            let session = bench.session()?;
            let mut plant = bare::BarePlant::open(&session, ours)?;
            bench.peer.order(&Order::Bare { session: session.name().into(), ours })?;
            let spread = trips(count, bench.plan.turn_ns, |seq| plant.ask(seq))?;
            plant.end()?;
            results.put(carrier.name(), "round trip", &spread);
            Ok(())
        }
        Carrier::Port(waiting) => {
            let session = bench.session()?;
            let mut initiator = Initiator::open(&session, &null_plant(), waiting, bench.stop)?;
            bench.peer.order(&Order::Echo {
                session: session.name().into(),
                waiting,
                system: RealtimeArgs::default(),
            })?;
            initiator.first_exchange()?;
            let mut sent = now_ns();
            let limit = sent + bench.plan.turn_ns;
            for seq in 2..=u64::from(count) {
                initiator.exchange(Sensors {
                    stamp: Stamp { seq, mono_ns: sent, ..Stamp::default() },
                    ..Sensors::default()
                })?;
                sent = initiator.received_ns;
                if sent > limit {
                    break;
                }
            }
            initiator.end(results, carrier.name())
        }
    }
}

fn sockets(bench: &Bench, results: &mut Results, carrier: Carrier, mut socket: Socket) -> Result<(), Failure> {
    let mut message = [0; SIZE];
    let count = bench.plan.trips[usize::from(carrier.sleeps())];
    let spread = trips(count, bench.plan.turn_ns, |_| socket.ask(&mut message))?;
    socket.end()?;
    results.put(carrier.name(), "round trip", &spread);
    Ok(())
}

/// Times each of many round trips, except the first one, during which the other side may still be starting.
fn trips(count: u32, limit_ns: u64, mut trip: impl FnMut(u32) -> Result<(), Failure>) -> Result<Spread, Failure> {
    let mut times = Vec::with_capacity(count as usize);
    trip(1)?;
    let mut begun = now_ns();
    let limit = begun + limit_ns;
    for seq in 2..=count {
        trip(seq)?;
        let ended = now_ns();
        times.push(ended - begun);
        begun = ended;
        if ended > limit {
            break;
        }
    }
    Spread::of(times)
}
