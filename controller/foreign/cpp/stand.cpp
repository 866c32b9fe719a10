// A standing controller: a spring and a damper hold every joint at its initial angle.
//
//     cargo build --release -p biped-c
//     c++ -std=c++17 controller/foreign/cpp/stand.cpp -o stand -I controller/foreign/c -I messages/include
//         -L target/release -lbiped_c -Wl,-rpath,"$PWD/target/release"
//     biped run stand --controller ./stand
#include "session.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>

constexpr double stiffness = 1000.0; // [N·m/rad]
constexpr double damping = 40.0;     // [N·m·s/rad]
constexpr double cut_off = 150.0;    // of the low-pass filter of the rates [Hz]
constexpr double turn = 6.283185307179586;

struct Joint {
    double angle, speed = 0.0;

    // Torque of a spring and a damper toward the angle `target`.
    double hold(double target, double now, double rate) {
        const double share = 1.0 - std::exp(-turn * cut_off / rate);
        speed += share * ((now - angle) * rate - speed);
        angle = now;
        return stiffness * (target - now) - damping * speed;
    }
};

int main() try {
    std::signal(SIGTERM, biped_stop);
    biped::Session session;
    const biped_Status robot = session.status();
    Joint joints[BIPED_JOINTS];
    while (session.wait()) {
        const biped_Encoders encoders = session.read();
        biped_Torques answer;
        for (int j = 0; j < BIPED_JOINTS; j++) {
            const double angle = robot.count * static_cast<double>(encoders.counts[j]);
            if (session.begins()) joints[j] = Joint{angle};
            const double torque = joints[j].hold(robot.start[j], angle, robot.rate);
            answer.torque[j] = std::clamp(torque, -robot.torque_limit, robot.torque_limit);
        }
        session.write(answer);
    }
    return 0;
} catch (const biped::Error &error) {
    if (error.code != -BIPED_STOPPED) std::cerr << "error: " << error.what() << '\n';
    return error.code;
}
