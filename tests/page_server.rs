//! Claims about the server of the page: it answers whoever has the token, refuses everybody else, and neither keeps nor waits for
//! what they send.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

#[path = "common/live.rs"]
mod live;

use live::{LONG, Running, biped, eventually};
use messages::port::Action;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Output};

/// A view, where it listens, and its token.
struct View {
    process: Child,
    place: SocketAddr,
    token: String,
}

impl View {
    fn open(walk: &Running, extra: &[&str]) -> View {
        let arguments = ["view", "--session", walk.session.name(), "--port", "0"];
        let mut process = biped(&[&arguments[..], extra].concat()).spawn().expect("the program starts");
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().expect("a pipe")).read_line(&mut line).expect("a line");
        let address = line.split_once("http://").and_then(|(_, rest)| rest.trim().split_once("/?token="));
        let (place, token) = address.unwrap_or_else(|| panic!("no address: {line}"));
        View { process, place: place.parse().expect("an address"), token: token.into() }
    }

    fn connect(&self) -> TcpStream {
        TcpStream::connect(self.place).expect("a server")
    }

    /// The whole answer to a request line, with headers and a body that may not be what they say.
    fn say(&self, request: &str) -> String {
        let mut stream = self.connect();
        let _ = stream.write_all(request.as_bytes()); // it may have hung up
        rest(&mut stream)
    }

    fn get(&self, path: &str, host: &str) -> String {
        self.say(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
    }

    /// Whether a browser that has the token gets the page.
    fn serves(&self) -> bool {
        self.get(&format!("/?token={}", self.token), &self.place.to_string()).contains("<title>biped: session test-")
    }

    /// Its open files, of which each connection is one.
    fn files(&self) -> usize {
        std::fs::read_dir(format!("/proc/{}/fd", self.process.id())).expect("open files").count()
    }

    /// The most memory that it has had [kB].
    fn memory(&self) -> i64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).expect("a process");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("its memory");
        line.trim().trim_end_matches(" kB").parse().expect("a number")
    }
}

/// All that still comes.
fn rest(stream: &mut TcpStream) -> String {
    let mut answer = vec![];
    stream.set_read_timeout(Some(LONG)).expect("a socket");
    let end = stream.read_to_end(&mut answer).map_err(|error| error.kind());
    assert_ne!(end, Err(ErrorKind::WouldBlock), "nobody hangs up"); // a reset is an end, too
    String::from_utf8_lossy(&answer).into()
}

#[test]
fn whoever_lacks_the_token_or_means_another_host_is_refused() {
    let walk = Running::unheard("token");
    walk.ask(Action::Pause);
    let view = View::open(&walk, &[]);
    let (token, here) = (&view.token, &view.place.to_string());
    assert!(token.len() == 32 && view.serves());
    let refused = ["/", "/?token=", "/ask", "/frames", "/nowhere", &format!("/frames?token={}0", &token[1..])];
    for path in [&refused[..], &[&format!("/?token={}", &token[1..]), &format!("/?token={token}0")]].concat() {
        let answer = view.get(path, here);
        assert!(answer.starts_with("HTTP/1.1 403") && answer.contains("`biped view` printed last"), "{path}: {answer}");
    }
    // What another site's page sends once its own name leads here.
    let port = view.place.port();
    for host in ["evil.example", &format!("evil.example:{port}"), "192.0.2.1", "127.0.0.1.evil.example", "", "[", "a b"]
    {
        let answer = view.get(&format!("/?token={token}"), host);
        assert!(!answer.starts_with("HTTP/1.1 200") && !answer.contains("<title>biped: session"), "{host}: {answer}");
    }
    let answer = view.say(&format!("GET /?token={token} HTTP/1.0\r\n\r\n"));
    assert!(answer.starts_with("HTTP/1.0 421") && answer.contains("open the address that"), "{answer}");
    for host in [&format!("localhost:{port}"), "LocalHost:1", "127.0.0.1", "[::1]:8642"] {
        assert!(view.get(&format!("/frames?token={token}"), host).starts_with("HTTP/1.1 200"), "{host}");
    }
    let bearer = |token: &str| {
        let head = format!(
            "GET /frames HTTP/1.1\r\nHost: {here}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n\r\n"
        );
        view.say(&head)
    };
    assert!(bearer(token).starts_with("HTTP/1.1 200") && bearer(&token[1..]).starts_with("HTTP/1.1 403"));
    for path in [format!("/?token={token}"), "/".into(), format!("/nowhere?token={token}")] {
        let head = view.get(&path, here).to_lowercase();
        for header in [
            "cache-control: no-store",
            "content-security-policy: default-src 'none'; script-src 'sha256-",
            "frame-ancestors 'none'",
            "referrer-policy: no-referrer",
            "x-content-type-options: nosniff",
        ] {
            assert!(head.split("\r\n\r\n").next().is_some_and(|head| head.contains(header)), "{path}: {header}");
        }
    }
    walk.end_with(view.process);
}

#[test]
fn endless_headers_and_bodies_and_silence_cost_no_memory_and_keep_nobody_out() {
    let walk = Running::unheard("onlooker");
    walk.ask(Action::Pause);
    let view = View::open(&walk, &[]);
    assert!(view.serves());
    let (files, memory, place, token) = (view.files(), view.memory(), view.place, &view.token);

    // A body of 100 GB that is announced, with and without the token, and one that has no end.
    let announced = |headers: &str, query: &str| {
        view.say(&format!("POST /ask{query} HTTP/1.1\r\nHost: {place}\r\n{headers}\r\n\r\n{}", "x".repeat(9000)))
    };
    let query = format!("?token={token}");
    for (length, known) in [("Content-Length: 100000000000", "413"), ("Transfer-Encoding: chunked", "413")] {
        assert!(announced(length, "").starts_with("HTTP/1.1 403"), "{length}");
        let answer = announced(length, &query);
        assert!(answer.is_empty() || answer.starts_with(&format!("HTTP/1.1 {known}")), "{length}: {answer}");
        assert!(view.serves());
    }
    let mut stream = view.connect();
    write!(stream, "GET / HTTP/1.1\r\nHost: {place}\r\n").expect("listening");
    let line = format!("X: {}\r\n", "x".repeat(1000));
    let lines = (0..1_000_000).take_while(|_| stream.write_all(line.as_bytes()).is_ok()).count();
    assert!(lines < 1_000_000, "it took a gigabyte of headers");

    // Half a request from each of more connections than it serves; others are served at once.
    let mut silent: Vec<TcpStream> = (0..300)
        .map(|_| {
            let mut stream = view.connect();
            let _ = write!(stream, "GET /?token="); // who is shown the door may hear of it here
            stream
        })
        .collect();
    assert!(view.serves(), "the silent keep others out");
    let most = view.files();
    assert!(most < files + 100, "{} connections at a time", most - files);
    silent.iter_mut().for_each(|stream| _ = rest(stream)); // each is hung up on
    // Half a body, from those who have the token.
    let mut slow: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut stream = view.connect();
            write!(stream, "POST /ask{query} HTTP/1.1\r\nHost: {place}\r\nContent-Length: 9\r\n\r\nx")
                .expect("listening");
            stream
        })
        .collect();
    assert!(view.serves(), "the slow keep others out");
    let answers: Vec<String> = slow.iter_mut().map(rest).collect();
    assert!(answers.iter().all(|answer| answer.is_empty() || answer.starts_with("HTTP/1.1 408")), "{answers:?}");
    eventually("an end of all connections", || view.files() == files);
    let more = view.memory() - memory;
    assert!(more < 16_000, "{more} kB more");
    walk.end_with(view.process);
}

#[test]
fn a_reader_that_stalls_stalls_nobody() {
    let walk = Running::unheard("stall");
    let view = View::open(&walk, &[]);
    // Browsers that ask for the page again and again and never read it: more than fits between us, from each.
    let before = view.files();
    let stalled: Vec<TcpStream> = (0..8)
        .map(|_| {
            let mut stream = view.connect();
            let request = format!("GET /?token={} HTTP/1.1\r\nHost: {}\r\n\r\n", view.token, view.place);
            stream.write_all(request.repeat(12).as_bytes()).expect("listening");
            stream
        })
        .collect();
    eventually("eight answers that nobody takes", || view.files() >= before + 8);
    let begin = walk.ask(Action::Resume).stamp.sim_ns;
    eventually("twenty seconds of lockstep", || walk.ask(Action::Resume).stamp.sim_ns > begin + 20_000_000_000);
    assert!(view.serves(), "others wait for them");
    eventually("an end of patience with each", || view.files() <= before);
    for mut stream in stalled {
        let length = rest(&mut stream).len();
        assert!(length < 12_000_000, "all of it was kept for whoever never read: {length} bytes");
    }
    walk.end_with(view.process);
}

#[test]
fn other_addresses_are_listened_on_if_asked_for_and_then_that_is_warned_of() {
    let walk = Running::unheard("listen");
    walk.ask(Action::Pause);
    for (listen, host, warnings) in [("0.0.0.0", "192.0.2.7:80", 1), ("::", "[2001:db8::7]:80", 1), ("::1", "[::1]", 0)]
    {
        let listening = listen.parse::<IpAddr>().expect("an address");
        if listening.is_ipv6() && TcpListener::bind("[::1]:0").is_err() {
            println!("this machine has no IPv6: {listen} is not tested");
            continue;
        }
        let view = View::open(&walk, &["--listen", listen]);
        assert!(view.place.is_ipv6() == listening.is_ipv6() && view.serves(), "{listen}");
        let path = format!("/frames?token={}", view.token);
        assert!(view.get(&path, host).starts_with("HTTP/1.1 200"), "{listen}: {host}");
        assert!(view.get(&path, "evil.example").starts_with("HTTP/1.1 421"), "{listen}");
        assert!(view.get("/", host).starts_with("HTTP/1.1 403"), "{listen}");
        kill(Pid::from_raw(view.process.id() as i32), Signal::SIGTERM).expect("a signal");
        let Output { status, stderr, .. } = view.process.wait_with_output().expect("our own child");
        let words = String::from_utf8_lossy(&stderr);
        assert!(
            status.success() && words.matches("warning: the page listens on ").count() == warnings,
            "{listen}: {words}"
        );
    }
    walk.end();
}
