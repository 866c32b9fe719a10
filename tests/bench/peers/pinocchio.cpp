// Pinocchio on the states that the bench wrote: forward dynamics, and the algorithms that it consists of.
//
//     c++ -O3 -march=x86-64-v2 pinocchio.cpp … && a.out biped8.urdf states.txt
//
// Prints `situation algorithm nanoseconds`, medians over the states.

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/config.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <map>

using Clock = std::chrono::steady_clock;
constexpr int REPEATS = 16, ROUNDS = 9, NUMBERS = 37;

static double median(std::vector<double> list) {
  std::nth_element(list.begin(), list.begin() + list.size() / 2, list.end());
  return list[list.size() / 2];
}

int main(int count, char **arguments) {
  std::ifstream file(count == 3 ? arguments[2] : "");
  if (!file) return std::cerr << "pinocchio.cpp ROBOT.urdf STATES\n", 2;
  pinocchio::Model model;
  pinocchio::urdf::buildModel(arguments[1], pinocchio::JointModelFreeFlyer(), model);
  std::cout << "version " << PINOCCHIO_VERSION << "\n";
  std::string name;
  int n;
  double gravity, friction, armature, stiffness, damping;
  while (file >> name >> n >> gravity >> friction >> armature >> stiffness >> damping) {
    model.gravity.linear() << 0, 0, -gravity;
    model.armature.tail(8).setConstant(armature);
    pinocchio::Data data(model);
    std::vector<Eigen::VectorXd> qs, vs, us;
    for (int i = 0; i < n; i++) {
      Eigen::VectorXd row(NUMBERS), q(15), v(14), u = Eigen::VectorXd::Zero(14);
      for (double &number : row) file >> number;
      q << row.head(3), row.segment(4, 3), row[3], row.segment(13, 8);
      const Eigen::Quaterniond turn(row[3], row[4], row[5], row[6]);
      v << turn.conjugate() * Eigen::Vector3d(row.segment(7, 3)), row.segment(10, 3), row.segment(21, 8);
      u.tail(8) = row.tail(8);
      qs.push_back(q), vs.push_back(v), us.push_back(u);
    }
    std::map<std::string, std::vector<double>> medians;
    Eigen::VectorXd a = Eigen::VectorXd::Zero(14);
    auto time = [&](const char *what, auto &&call) {
      for (int round = 0; round < ROUNDS; round++) {
        std::vector<double> times;
        for (int i = 0; i < n; i++) {
          call(i);
          const auto begun = Clock::now();
          for (int r = 0; r < REPEATS; r++) call(i);
          times.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begun).count() / REPEATS);
        }
        medians[what].push_back(median(times));
      }
    };
    using namespace pinocchio;
    time("kinematics", [&](int i) { forwardKinematics(model, data, qs[i], vs[i]); });
    time("inertia", [&](int i) { crba(model, data, qs[i], Convention::WORLD); });
    time("bias", [&](int i) { nonLinearEffects(model, data, qs[i], vs[i]); });
    time("rnea", [&](int i) { rnea(model, data, qs[i], vs[i], us[i]); });
    time("factor", [&](int i) { (void)i, cholesky::decompose(model, data); });
    time("solve", [&](int i) { a = us[i], cholesky::solve(model, data, a); });
    time("aba", [&](int i) { aba(model, data, qs[i], vs[i], us[i], Convention::WORLD); });
    time("dynamics", [&](int i) {
      crba(model, data, qs[i], Convention::WORLD);
      nonLinearEffects(model, data, qs[i], vs[i]);
      cholesky::decompose(model, data);
      a = us[i] - data.nle;
      cholesky::solve(model, data, a);
    });
    for (auto &[what, list] : medians) std::cout << name << " " << what << " " << median(list) << "\n";
  }
}
