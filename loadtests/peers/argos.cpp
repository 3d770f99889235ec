// ARGoS: its e-puck in the 2D dynamics engine, no picture, no threads. What it is told stands in an XML
// file that is written here.
#include <unistd.h>

#include <argos3/core/control_interface/ci_controller.h>
#include <argos3/core/simulator/entity/embodied_entity.h>
#include <argos3/core/simulator/simulator.h>
#include <argos3/core/simulator/space/space.h>
#include <argos3/plugins/robots/e-puck/control_interface/ci_epuck_proximity_sensor.h>
#include <argos3/plugins/robots/e-puck/simulator/epuck_entity.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_actuator.h>

#include "common.h"

namespace {

// Whole ticks a second: speeds are stretched so that a step goes as far as one of 64 ms.
constexpr int TICKS_PER_SECOND = 16;
constexpr double STRETCH = STEP_S * TICKS_PER_SECOND;
constexpr double WALL_M = 0.002, OUTER_M = 0.05;

} // namespace

class Driven : public argos::CCI_Controller {
  public:
    argos::CCI_EPuckProximitySensor* eyes = nullptr;

    void Init(argos::TConfigurationNode&) override {
        wheels = GetActuator<argos::CCI_DifferentialSteeringActuator>("differential_steering");
        eyes = GetSensor<argos::CCI_EPuckProximitySensor>("epuck_proximity");
        number = std::strtoull(GetId().c_str() + 1, nullptr, 10);
    }
    void ControlStep() override {
        const Speeds v = speeds(number, step++);
        wheels->SetLinearVelocity(100 * STRETCH * v.left, 100 * STRETCH * v.right);
    }

  private:
    argos::CCI_DifferentialSteeringActuator* wheels = nullptr;
    uint64_t number = 0, step = 0;
};
REGISTER_CONTROLLER(Driven, "driven")

int main(int argc, char** argv) {
    const Options options(argc, argv);
    const Arena arena = read_arena(options.world);
    const std::string file = options.value("scratch", ".") + "/argos-" + std::to_string(getpid()) + ".argos";
    const double w = arena.width, h = arena.height, degrees = 180 / M_PI;
    std::ofstream xml(file);
    const auto box = [&](const std::string& id, double long_m, double wide_m, double x, double y, double heading) {
        xml << "<box id=\"" << id << "\" size=\"" << long_m << "," << wide_m << ",0.1\" movable=\"false\"><body position=\""
            << x << "," << y << ",0\" orientation=\"" << heading * degrees << ",0,0\"/></box>\n";
    };
    xml << "<argos-configuration><framework><system threads=\"0\"/><experiment length=\"0\" ticks_per_second=\""
        << TICKS_PER_SECOND << "\" random_seed=\"1\"/></framework>\n<controllers><driven id=\"d\"><actuators>"
        << "<differential_steering implementation=\"default\"/></actuators><sensors><epuck_proximity "
        << "implementation=\"default\" show_rays=\"false\"/></sensors><params/></driven></controllers>\n"
        << "<arena size=\"" << w + 1 << "," << h + 1 << ",1\" center=\"" << w / 2 << "," << h / 2 << ",0.5\">\n";
    box("west", OUTER_M, h + 2 * OUTER_M, -OUTER_M / 2, h / 2, 0);
    box("east", OUTER_M, h + 2 * OUTER_M, w + OUTER_M / 2, h / 2, 0);
    box("south", w + 2 * OUTER_M, OUTER_M, w / 2, -OUTER_M / 2, 0);
    box("north", w + 2 * OUTER_M, OUTER_M, w / 2, h + OUTER_M / 2, 0);
    for (size_t i = 0; i < arena.walls.size(); ++i) {
        const Wall& wall = arena.walls[i];
        box("w" + std::to_string(i), std::hypot(wall.bx - wall.ax, wall.by - wall.ay), WALL_M, (wall.ax + wall.bx) / 2,
            (wall.ay + wall.by) / 2, std::atan2(wall.by - wall.ay, wall.bx - wall.ax));
    }
    for (size_t i = 0; i < arena.starts.size(); ++i) {
        const Start& start = arena.starts[i];
        xml << "<e-puck id=\"e" << i << "\"><body position=\"" << start.x << "," << start.y << ",0\" orientation=\""
            << start.heading * degrees << ",0,0\"/><controller config=\"d\"/></e-puck>\n";
    }
    xml << "</arena>\n<physics_engines><dynamics2d id=\"plane\" iterations=\"" << options.value("iterations", "2")
        << "\"/></physics_engines>\n<media/></argos-configuration>\n";
    xml.close();

    argos::CSimulator& simulator = argos::CSimulator::GetInstance();
    simulator.SetExperimentFileName(file);
    simulator.LoadExperiment();
    unlink(file.c_str());
    std::vector<argos::CEPuckEntity*> robots;
    for (size_t i = 0; i < arena.starts.size(); ++i)
        robots.push_back(&dynamic_cast<argos::CEPuckEntity&>(simulator.GetSpace().GetEntity("e" + std::to_string(i))));
    const auto home = robots[0]->GetEmbodiedEntity().GetOriginAnchor();

    Sums sums(robots.size());
    long outside = 0;
    for (long step = 0; step < options.steps; ++step) {
        if (robots.size() == 1 && step % EPISODE == 0)
            robots[0]->GetEmbodiedEntity().MoveTo(home.Position, home.Orientation);
        if (!options.check) {
            simulator.UpdateSpace();
            continue;
        }
        for (size_t i = 0; i < robots.size(); ++i) {
            const auto& at = robots[i]->GetEmbodiedEntity().GetOriginAnchor().Position;
            sums.from(i, at.GetX(), at.GetY());
        }
        simulator.UpdateSpace();
        for (size_t i = 0; i < robots.size(); ++i) {
            auto& body = robots[i]->GetEmbodiedEntity();
            const auto& at = body.GetOriginAnchor().Position;
            outside += at.GetX() < 0 || at.GetY() < 0 || at.GetX() > w || at.GetY() > h;
            sums.to(i, at.GetX(), at.GetY(), body.IsCollidingWithSomething());
            auto& driven = dynamic_cast<Driven&>(robots[i]->GetControllableEntity().GetController());
            for (const auto& reading : driven.eyes->GetReadings()) {
                // Its response, turned around; it sees no farther than 50 mm.
                const double a = 298.701, b = -36.8961, c = 1.08212 - reading.Value;
                const double root = std::sqrt(std::fmax(0, b * b - 4 * a * c));
                sums.ray((-b - root) / (2 * a), reading.Value > 0);
            }
        }
    }
    if (options.check) {
        if (outside > 0) std::printf("outside %ld\n", outside);
        sums.print();
    }
    std::fflush(stdout);
    _exit(0);
}
