// The controller's end of a session for C++17: controller.h with a destructor and exceptions.
#pragma once

#include "controller.h"

#include <stdexcept>

namespace biped {

// A failed call: what() is its sentence, code the exit code for the program.
struct Error : std::runtime_error {
    int code;
    explicit Error(int result) : std::runtime_error(biped_last_error()), code(-result) {}
};

class Session {
public:
    Session() { check(biped_open(&controller)); }
    explicit Session(const char *name, double patience = 10.0) { check(biped_attach(&controller, name, patience)); }
    ~Session() { biped_close(&controller); }
    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    // Waits for the next reading of the encoders; false after the plant's goodbye.
    bool wait() {
        result = check(biped_wait(controller));
        return result != BIPED_GOODBYE;
    }

    // Whether the reading is the first of a run. The controller must then start from its initial state.
    bool begins() const { return result == BIPED_BEGIN; }

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
    int result = BIPED_GOODBYE;

    static int check(int result) {
        if (result < 0) throw Error(result);
        return result;
    }
};

} // namespace biped
