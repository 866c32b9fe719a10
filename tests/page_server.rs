//! Claims about the server of the page: it answers clients that have the token, refuses all others, and neither stores nor waits for
//! their data.

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

/// A running `biped view`, with its address and token.
struct ViewServer {
    process: Child,
    address: SocketAddr,
    token: String,
}

impl ViewServer {
    fn open(walk: &Running, extra: &[&str]) -> ViewServer {
        let arguments = ["view", "--session", walk.session.name(), "--port", "0"];
        let mut process = biped(&[&arguments[..], extra].concat()).spawn().expect("the program starts");
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().expect("a pipe")).read_line(&mut line).expect("a line");
        let address = line.split_once("http://").and_then(|(_, rest)| rest.trim().split_once("/?token="));
        let (address, token) = address.unwrap_or_else(|| panic!("no address: {line}"));
        ViewServer { process, address: address.parse().expect("an address"), token: token.into() }
    }

    fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address).expect("a server")
    }

    /// Sends a raw request, which may be malformed, and returns the whole answer.
    fn send(&self, request: &str) -> String {
        self.send_bytes(request.as_bytes())
    }

    fn send_bytes(&self, request: &[u8]) -> String {
        let mut stream = self.connect();
        let _ = stream.write_all(request); // the server may have closed the connection
        read_to_end(&mut stream)
    }

    fn get(&self, path: &str, host: &str) -> String {
        self.send(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
    }

    /// Whether a browser that has the token gets the page.
    fn serves(&self) -> bool {
        self.get(&format!("/?token={}", self.token), &self.address.to_string()).contains("<title>biped: session test-")
    }

    /// Number of its open files; each connection is one.
    fn open_files(&self) -> usize {
        std::fs::read_dir(format!("/proc/{}/fd", self.process.id())).expect("open files").count()
    }

    /// Peak resident memory [kB].
    fn peak_memory(&self) -> i64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).expect("a process");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("its memory");
        line.trim().trim_end_matches(" kB").parse().expect("a number")
    }
}

/// Reads until the server closes the connection.
fn read_to_end(stream: &mut TcpStream) -> String {
    let mut answer = vec![];
    stream.set_read_timeout(Some(LONG)).expect("a socket");
    let end = stream.read_to_end(&mut answer).map_err(|error| error.kind());
    assert_ne!(end, Err(ErrorKind::WouldBlock), "the connection stays open"); // a reset closes it, too
    String::from_utf8_lossy(&answer).into()
}

#[test]
fn requests_without_the_token_or_for_another_host_are_refused() {
    let walk = Running::unobserved("token");
    walk.ask(Action::Pause);
    let view = ViewServer::open(&walk, &[]);
    let (token, here) = (&view.token, &view.address.to_string());
    assert!(token.len() == 32 && view.serves());
    let refused = ["/", "/?token=", "/ask", "/frames", "/nowhere", &format!("/frames?token={}0", &token[1..])];
    for path in [&refused[..], &[&format!("/?token={}", &token[1..]), &format!("/?token={token}0")]].concat() {
        let answer = view.get(path, here);
        assert!(answer.starts_with("HTTP/1.1 403") && answer.contains("`biped view` printed last"), "{path}: {answer}");
    }
    // DNS rebinding: a page of another site, whose name now resolves to this server.
    let port = view.address.port();
    for host in ["evil.example", &format!("evil.example:{port}"), "192.0.2.1", "127.0.0.1.evil.example", "", "[", "a b"]
    {
        let answer = view.get(&format!("/?token={token}"), host);
        assert!(!answer.starts_with("HTTP/1.1 200") && !answer.contains("<title>biped: session"), "{host}: {answer}");
    }
    let answer = view.send(&format!("GET /?token={token} HTTP/1.0\r\n\r\n"));
    assert!(answer.starts_with("HTTP/1.0 421") && answer.contains("open the address that"), "{answer}");
    for host in [&format!("localhost:{port}"), "LocalHost:1", "127.0.0.1", "[::1]:8642"] {
        assert!(view.get(&format!("/frames?token={token}"), host).starts_with("HTTP/1.1 200"), "{host}");
    }
    let bearer = |token: &str| {
        let head = format!(
            "GET /frames HTTP/1.1\r\nHost: {here}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n\r\n"
        );
        view.send(&head)
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
fn endless_requests_and_silent_clients_use_no_memory_and_block_nobody() {
    let walk = Running::unobserved("onlooker");
    walk.ask(Action::Pause);
    let view = ViewServer::open(&walk, &[]);
    assert!(view.serves());
    let (files, memory, address, token) = (view.open_files(), view.peak_memory(), view.address, &view.token);

    // A body with an announced length of 100 GB, with and without the token, and an endless one.
    let announced = |headers: &str, query: &str| {
        view.send(&format!("POST /ask{query} HTTP/1.1\r\nHost: {address}\r\n{headers}\r\n\r\n{}", "x".repeat(9000)))
    };
    let query = format!("?token={token}");
    for (length, known) in [("Content-Length: 100000000000", "413"), ("Transfer-Encoding: chunked", "413")] {
        assert!(announced(length, "").starts_with("HTTP/1.1 403"), "{length}");
        let answer = announced(length, &query);
        assert!(answer.is_empty() || answer.starts_with(&format!("HTTP/1.1 {known}")), "{length}: {answer}");
        assert!(view.serves());
    }
    let mut stream = view.connect();
    write!(stream, "GET / HTTP/1.1\r\nHost: {address}\r\n").expect("listening");
    let line = format!("X: {}\r\n", "x".repeat(1000));
    let lines = (0..1_000_000).take_while(|_| stream.write_all(line.as_bytes()).is_ok()).count();
    assert!(lines < 1_000_000, "it took a gigabyte of headers");

    // Half a request from each of more connections than the server accepts. Other clients are still served at once.
    let mut silent: Vec<TcpStream> = (0..300)
        .map(|_| {
            let mut stream = view.connect();
            let _ = write!(stream, "GET /?token="); // fails if the server has already closed the connection
            stream
        })
        .collect();
    assert!(view.serves(), "silent clients block others");
    let most = view.open_files();
    assert!(most < files + 100, "{} connections at a time", most - files);
    silent.iter_mut().for_each(|stream| _ = read_to_end(stream)); // the server closes each connection
    // Half a body, from clients that have the token.
    let mut slow: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut stream = view.connect();
            write!(stream, "POST /ask{query} HTTP/1.1\r\nHost: {address}\r\nContent-Length: 9\r\n\r\nx")
                .expect("listening");
            stream
        })
        .collect();
    assert!(view.serves(), "slow clients block others");
    let answers: Vec<String> = slow.iter_mut().map(read_to_end).collect();
    assert!(answers.iter().all(|answer| answer.is_empty() || answer.starts_with("HTTP/1.1 408")), "{answers:?}");
    eventually("an end of all connections", || view.open_files() == files);
    let more = view.peak_memory() - memory;
    assert!(more < 16_000, "{more} kB more");
    walk.end_with(view.process);
}

/// All with the token: an authorised client may be broken too.
#[test]
fn malformed_requests_get_an_answer_or_an_end_and_the_next_client_is_served() {
    let walk = Running::unobserved("malformed");
    walk.ask(Action::Pause);
    let view = ViewServer::open(&walk, &[]);
    let memory = view.peak_memory();
    let head = format!("Host: {}\r\nAuthorization: Bearer {}\r\n", view.address, view.token);
    let close = format!("{head}Connection: close\r\n");
    let chunked = format!("POST /ask HTTP/1.1\r\n{close}Transfer-Encoding: chunked\r\n\r\n");
    let long = "x".repeat(1 << 20);
    let get = |path: &[u8]| [b"GET ", path, b" HTTP/1.1\r\n", close.as_bytes(), b"\r\n"].concat();
    for (request, statuses) in [
        (format!("{chunked}10\r\n{{\"what\":\"pause\"}}\r\n0\r\n\r\n").into_bytes(), &["200"][..]),
        (format!("{chunked}fffffffffffffffff1\r\nx").into_bytes(), &["400", "413"]), // beyond 64 bits
        (format!("{chunked}1;{long}").into_bytes(), &["400", "413", ""]),            // an endless extension
        (format!("{chunked}0\r\nx: {long}\r\n").into_bytes(), &["400", "413", ""]),  // an endless trailer
        (
            format!("POST /ask HTTP/1.1\r\n{close}Content-Length: 3\r\nContent-Length: 5\r\n\r\nabcde").into_bytes(),
            &["400"],
        ),
        (format!("POST /ask HTTP/1.1\r\n{close}Content-Length: -3\r\n\r\nabc").into_bytes(), &["400"]),
        (
            format!("POST /ask HTTP/1.1\r\n{close}Content-Length: 99999999999999999999999\r\n\r\n").into_bytes(),
            &["400"],
        ),
        (format!("GET /{long} HTTP/1.1\r\n{close}\r\n").into_bytes(), &["414", "431", ""]),
        (format!("GET / HTTP/1.1\r\n{}{close}\r\n", "a: b\r\n".repeat(200)).into_bytes(), &["431"]),
        (get(b"/\xff\xfe"), &["400", "404"]),
        (get(b"/%ff%00"), &["404"]),
        (get(b"/frames?from=-1&run=99999999999999999999999"), &["200"]),
        (
            format!("GET /nope HTTP/1.1\r\n{head}\r\n")
                .repeat(500)
                .into_bytes()
                .into_iter()
                .chain(get(b"/nope"))
                .collect(),
            &["404"],
        ),
        (format!("GET / HTTP/1.1\r\n{head}Connection: Upgrade\r\nUpgrade: websocket\r\n\r\n").into_bytes(), &["200"]),
        (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(), &["400", "505", ""]),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".repeat(60), &["400", ""]), // a browser that wants TLS
    ] {
        let shown = String::from_utf8_lossy(&request[..request.len().min(200)]).into_owned();
        let answer = view.send_bytes(&request);
        let status = answer.split(' ').nth(1).unwrap_or_default();
        assert!(statuses.contains(&status), "{shown}: {}", &answer[..answer.len().min(200)]);
        assert!(view.serves(), "after {shown}");
    }
    let more = view.peak_memory() - memory;
    assert!(more < 16_000, "{more} kB more");
    walk.end_with(view.process);
}

#[test]
fn a_stalled_reader_blocks_nobody() {
    let walk = Running::unobserved("stall");
    let view = ViewServer::open(&walk, &[]);
    // Clients that request the page repeatedly and never read it, each for more bytes than the socket buffers hold.
    let before = view.open_files();
    let stalled: Vec<TcpStream> = (0..8)
        .map(|_| {
            let mut stream = view.connect();
            let request = format!("GET /?token={} HTTP/1.1\r\nHost: {}\r\n\r\n", view.token, view.address);
            stream.write_all(request.repeat(12).as_bytes()).expect("listening");
            stream
        })
        .collect();
    eventually("eight answers that nobody reads", || view.open_files() >= before + 8);
    let begin = walk.ask(Action::Resume).stamp.sim_ns;
    eventually("twenty seconds of lockstep", || walk.ask(Action::Resume).stamp.sim_ns > begin + 20_000_000_000);
    assert!(view.serves(), "stalled clients block others");
    eventually("the end of all stalled connections", || view.open_files() <= before);
    for mut stream in stalled {
        let length = read_to_end(&mut stream).len();
        assert!(length < 12_000_000, "the server buffered everything for a client that never read: {length} bytes");
    }
    walk.end_with(view.process);
}

#[test]
fn listening_on_other_addresses_needs_an_option_and_prints_a_warning() {
    let walk = Running::unobserved("listen");
    walk.ask(Action::Pause);
    for (listen, host, warnings) in [("0.0.0.0", "192.0.2.7:80", 1), ("::", "[2001:db8::7]:80", 1), ("::1", "[::1]", 0)]
    {
        let listening = listen.parse::<IpAddr>().expect("an address");
        if listening.is_ipv6() && TcpListener::bind("[::1]:0").is_err() {
            println!("this machine has no IPv6: {listen} is not tested");
            continue;
        }
        let view = ViewServer::open(&walk, &["--listen", listen]);
        assert!(view.address.is_ipv6() == listening.is_ipv6() && view.serves(), "{listen}");
        let path = format!("/frames?token={}", view.token);
        assert!(view.get(&path, host).starts_with("HTTP/1.1 200"), "{listen}: {host}");
        assert!(view.get(&path, "evil.example").starts_with("HTTP/1.1 421"), "{listen}");
        assert!(view.get("/", host).starts_with("HTTP/1.1 403"), "{listen}");
        kill(Pid::from_raw(view.process.id() as i32), Signal::SIGTERM).expect("a signal");
        let Output { status, stderr, .. } = view.process.wait_with_output().expect("our own child");
        let text = String::from_utf8_lossy(&stderr);
        assert!(
            status.success() && text.matches("warning: the page listens on ").count() == warnings,
            "{listen}: {text}"
        );
    }
    walk.end();
}
