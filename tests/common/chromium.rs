//! A headless browser, controlled through two pipes by Chrome's DevTools protocol: a sequence of JSON objects, each terminated by a zero byte.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use super::fresh_path;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for any condition: far more than a busy machine needs.
const LONG: Duration = Duration::from_secs(90);

/// A browser with one page.
pub struct Browser {
    process: Child,
    commands: File,
    events: BufReader<File>,
    folder: PathBuf,
    page: String,
    count: u64,
    /// Errors of the page: exceptions and messages on its console.
    pub complaints: Vec<String>,
    /// Addresses that the page requested.
    pub requests: Vec<String>,
}

impl Browser {
    /// Starts the browser, and opens a page in a window of the given size.
    pub fn open(address: &str, width: u32, height: u32) -> Browser {
        let folder = fresh_path("chromium");
        std::fs::create_dir(&folder).expect("a folder of our own");
        let [commands, events] = ["commands", "events"].map(|name| folder.join(name));
        for pipe in [&commands, &events] {
            nix::unistd::mkfifo(pipe, nix::sys::stat::Mode::S_IRWXU).expect("a pipe");
        }
        let program = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(|name| {
            Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
        });
        let program = program.expect("Chromium is needed: apt-get install chromium");
        // A shell connects the pipes as file descriptors 3 and 4.
        let process = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<\"$COMMANDS\" 4>\"$EVENTS\"", program])
            .args(["--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            // WebGL is emulated on the CPU; the rest of the page is drawn as on a machine without a GPU.
            .arg("--disable-gpu-compositing")
            .args(["--remote-debugging-pipe", "--disable-background-networking", "--no-first-run", "--hide-scrollbars"])
            .arg(format!("--user-data-dir={}", folder.join("profile").display()))
            .envs([("COMMANDS", &commands), ("EVENTS", &events)])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("a shell");
        let commands = File::options().write(true).open(&commands).expect("our own pipe");
        let events = BufReader::new(File::open(&events).expect("our own pipe"));
        let (complaints, requests) = (vec![], vec![]);
        let mut browser =
            Browser { process, commands, events, folder, page: String::new(), count: 0, complaints, requests };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let session = browser.call("Target.attachToTarget", json!({"targetId": target["targetId"], "flatten": true}));
        browser.page = session["sessionId"].as_str().expect("a session").into();
        for domain in ["Runtime", "Log", "Network", "Page"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.resize(width, height);
        browser.call("Page.navigate", json!({"url": address}));
        browser.until("document.readyState === 'complete'");
        browser
    }

    /// Emulates a screen of this size. A narrow one is a phone.
    pub fn resize(&mut self, width: u32, height: u32) {
        let screen = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600});
        self.call("Emulation.setDeviceMetricsOverride", screen);
    }

    /// Emulates a system with a preference for dark or light.
    pub fn prefers(&mut self, scheme: &str) {
        let features = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.call("Emulation.setEmulatedMedia", features);
    }

    /// Evaluates an expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let answer = self.call("Runtime.evaluate", evaluation(expression));
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Evaluates an expression to a number.
    pub fn number(&mut self, expression: &str) -> f64 {
        self.value(expression).as_f64().unwrap_or_else(|| panic!("{expression} is no number"))
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str) {
        let (start, request) = (Instant::now(), evaluation(expression));
        // Between two pages there is no answer.
        let holds = |answer: Result<Value, Value>| {
            let answer = answer.unwrap_or_default();
            assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
            answer["result"]["value"] == json!(true)
        };
        while !holds(self.attempt("Runtime.evaluate", request.clone())) {
            assert!(start.elapsed() < LONG, "{expression} did not come true; {:?}", self.complaints);
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// A screenshot as PNG.
    pub fn picture(&mut self) -> Vec<u8> {
        use base64::Engine;
        let picture = self.call("Page.captureScreenshot", json!({"format": "png"}));
        let text = picture["data"].as_str().expect("a picture");
        base64::prelude::BASE64_STANDARD.decode(text).expect("base 64")
    }

    /// Drags with the left button along a path, without releasing it.
    pub fn drag(&mut self, places: &[[f64; 2]]) {
        for (index, place) in places.iter().enumerate() {
            if index == 0 {
                self.mouse("mouseMoved", *place, 0, 0);
            }
            self.mouse(if index == 0 { "mousePressed" } else { "mouseMoved" }, *place, 1, 1);
        }
    }

    /// Releases the left button.
    pub fn drop_at(&mut self, place: [f64; 2]) {
        self.mouse("mouseReleased", place, 0, 1);
    }

    /// Clicks a number of times in a row.
    pub fn click(&mut self, place: [f64; 2], times: u32) {
        self.mouse("mouseMoved", place, 0, 0);
        for count in 1..=times {
            self.mouse("mousePressed", place, 1, count);
            self.mouse("mouseReleased", place, 0, count);
        }
    }

    /// Presses and releases a key, by its name.
    pub fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let text = if key.len() == 1 && kind == "keyDown" { key } else { "" };
            let code = if key == "Escape" { 27 } else { 0 };
            let event = json!({"type": kind, "key": key, "code": key, "text": text, "windowsVirtualKeyCode": code});
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], buttons: u32, count: u32) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        let event = json!({"type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": count});
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Moves a finger along a path, from touch to release.
    pub fn swipe(&mut self, places: &[[f64; 2]]) {
        for (index, [x, y]) in places.iter().enumerate() {
            let kind = if index == 0 { "touchStart" } else { "touchMove" };
            self.call("Input.dispatchTouchEvent", json!({"type": kind, "touchPoints": [{"x": x, "y": y}]}));
        }
        self.call("Input.dispatchTouchEvent", json!({"type": "touchEnd", "touchPoints": []}));
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.attempt(method, parameters).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    fn attempt(&mut self, method: &str, parameters: Value) -> Result<Value, Value> {
        self.count += 1;
        let mut message = json!({"id": self.count, "method": method, "params": parameters});
        if !self.page.is_empty() {
            message["sessionId"] = json!(self.page);
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).expect("an open pipe to the browser");
        loop {
            let mut answer = vec![];
            self.events.read_until(0, &mut answer).expect("an open pipe from the browser");
            answer.pop().unwrap_or_else(|| panic!("the browser exited during {method}"));
            let answer: Value = serde_json::from_slice(&answer).expect("JSON");
            match answer["id"].as_u64() {
                Some(id) if id == self.count => {
                    return answer
                        .get("error")
                        .map_or_else(|| Ok(answer["result"].clone()), |error| Err(error.clone()));
                }
                _ => self.note(&answer),
            }
        }
    }

    fn note(&mut self, event: &Value) {
        let what = &event["params"];
        match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.complaints.push(what["exceptionDetails"].to_string()),
            Some("Runtime.consoleAPICalled") if what["type"] == "error" => {
                self.complaints.push(what["args"].to_string())
            }
            Some("Log.entryAdded") if what["entry"]["level"] == "error" => {
                self.complaints.push(what["entry"]["text"].to_string());
            }
            Some("Network.requestWillBeSent") => {
                self.requests.push(what["request"]["url"].as_str().unwrap_or("?").into());
            }
            _ => (),
        }
    }
}

fn evaluation(expression: &str) -> Value {
    json!({"expression": expression, "returnByValue": true, "awaitPromise": true})
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its child processes exit when their pipes close.
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
