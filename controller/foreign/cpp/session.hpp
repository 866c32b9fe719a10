// A controller's end of a session for C++17: controller.h, closed by its destructor, errors as exceptions.
#pragma once

#include "controller.h"

#include <stdexcept>

namespace biped {

// A failed call: what() is a sentence, code the exit code to end with.
struct Error : std::runtime_error {
    int code;
    explicit Error(int said) : std::runtime_error(biped_last_error()), code(-said) {}
};

class Session {
public:
    Session() { check(biped_open(&controller)); }
    explicit Session(const char *name, double patience = 10.0) { check(biped_attach(&controller, name, patience)); }
    ~Session() { biped_close(&controller); }
    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    // Waits for the next encoders; false after the plant's goodbye.
    bool wait() {
        said = check(biped_wait(controller));
        return said != BIPED_GOODBYE;
    }

    // Whether they are the first of a run: forget what was before.
    bool begins() const { return said == BIPED_BEGIN; }

    biped_Encoders read() {
        biped_Encoders encoders;
        check(biped_read(controller, &encoders));
        return encoders;
    }

    void write(const biped_Torques &torques) { check(biped_write(controller, &torques, nullptr)); }

    void write(const biped_Torques &torques, const biped_Telemetry &telemetry) {
        check(biped_write(controller, &torques, &telemetry));
    }

    biped_Status status() {
        biped_Status status;
        check(biped_status(controller, &status));
        return status;
    }

private:
    biped_Controller *controller = nullptr;
    int said = BIPED_GOODBYE;

    static int check(int said) {
        if (said < 0) throw Error(said);
        return said;
    }
};

} // namespace biped
