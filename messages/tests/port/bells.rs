//! Two programs wake each other by a word in shared memory, the bell, if both have one. Else they use the event of iceoryx2.

use super::*;
use nix::libc;
use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};

/// A side falls back to the event if the other one does not sign the bell.
#[test]
fn a_program_with_bells_and_one_without_can_exchange_messages() {
    let [plant, controller] = EPOCHS;
    all_sensors_are_answered(1_000, [Waiting::Event; 2], [plant, 0]);
    all_sensors_are_answered(1_000, [Waiting::Event; 2], [0, controller]);
}

/// From here on, this thread can neither write to nor read from a socket: both give "permission denied".
fn refuse_sockets() {
    let calls = [libc::SYS_sendto, libc::SYS_sendmsg, libc::SYS_recvfrom, libc::SYS_recvmsg];
    let filter = SeccompFilter::new(
        calls.into_iter().map(|call| (call, vec![])).collect(),
        SeccompAction::Allow,
        SeccompAction::Errno(libc::EACCES as u32),
        std::env::consts::ARCH.try_into().expect("x86-64 or Arm"),
    );
    let program: BpfProgram = filter.and_then(TryInto::try_into).expect("a filter");
    seccompiler::apply_filter(&program).expect("a filter of this thread");
}

/// Exchanges messages, takes the sockets away from the plant, and exchanges as many again. Returns the result of the second exchange.
fn exchange_without_sockets([plant, controller]: [u64; 2]) -> Result<(), PortError> {
    const HALF: u64 = 1_000;
    let session = Session::unique();
    std::thread::scope(|scope| {
        scope.spawn(|| answer(&session, Waiting::Event, controller));
        let plant = scope.spawn(|| {
            let mut port = PlantPort::open(&session, &contract()).expect("plant").waiting(Waiting::Event);
            (1..=HALF).try_for_each(|seq| ask(&mut port, seq, plant)).expect("answers");
            refuse_sockets();
            let second = (HALF + 1..=2 * HALF).try_for_each(|seq| ask(&mut port, seq, plant));
            let _ = port.send(Sensors { last: 1, ..sensors(2 * HALF + 1, plant) }); // It is written, even if nobody can be woken.
            second
        });
        plant.join().expect("the plant")
    })
}

/// The reason for the bell: the event takes eight system calls for each message and goes through a socket, the bell takes two.
#[test]
fn the_bell_needs_no_socket_and_the_event_does() {
    exchange_without_sockets(EPOCHS).expect("the bell wakes both");
    let refused = exchange_without_sockets(WITHOUT_BELLS).expect_err("the event is a socket");
    assert!(refused.to_string().contains("wake-up"), "{refused}");
}
