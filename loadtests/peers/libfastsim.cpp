// libfastsim: one robot on a map of pixels. It has no other robots to meet.
#include <memory>

#include "map.hpp"
#include "robot.hpp"

#include "common.h"

int main(int argc, char** argv) {
    const Options options(argc, argv);
    const Arena arena = read_arena(options.world);
    if (arena.starts.size() != 1) {
        std::cerr << "libfastsim moves one robot\n";
        return 2;
    }
    // Lengths in millimetres; a border of pixels is the outer wall.
    const double pixel_mm = std::atof(options.value("pixel_mm", "3").c_str());
    constexpr int BORDER = 4;
    const double side_mm = 1e3 * std::fmax(arena.width, arena.height);
    const int pixels = int(std::ceil(side_mm / pixel_mm - 1e-6)) + 2 * BORDER;
    const auto map = std::make_shared<fastsim::Map>(pixels, pixels, float(pixels * pixel_mm));
    // A length is rounded to the nearest pixel, so pixel i has its middle at i.
    const auto mm = [&](double metres) { return float(1e3 * metres + (BORDER - 0.5) * pixel_mm); };
    for (int y = 0; y < pixels; ++y)
        for (int x = 0; x < pixels; ++x) {
            const bool wall = x < BORDER || y < BORDER || x >= pixels - BORDER || y >= pixels - BORDER;
            map->set_pixel(x, y, wall ? fastsim::Map::obstacle : fastsim::Map::free);
        }
    for (const Wall& wall : arena.walls) {
        const int dots = 2 + int(4e3 * std::hypot(wall.bx - wall.ax, wall.by - wall.ay) / pixel_mm);
        for (int i = 0; i <= dots; ++i) {
            const double t = double(i) / dots;
            map->set_pixel(map->real_to_pixel(mm(wall.ax + t * (wall.bx - wall.ax))),
                           map->real_to_pixel(mm(wall.ay + t * (wall.by - wall.ay))), fastsim::Map::obstacle);
        }
    }

    const Start& start = arena.starts[0];
    const fastsim::Posture home(mm(start.x), mm(start.y), float(start.heading));
    fastsim::Robot robot(float(1e3 * BODY_RADIUS_M), home);
    for (const auto& mount : MOUNTS)
        robot.add_laser(fastsim::Laser(float(mount[2]), float(1e3 * SENSOR_RANGE_M),
                                       float(1e3 * std::hypot(mount[0], mount[1])),
                                       float(std::atan2(mount[1], mount[0]))));
    // Its axle is as wide as the robot: wheel speeds are stretched so that it turns as ours does.
    const double turn = 2 * BODY_RADIUS_M / AXLE_M;

    Sums sums(1);
    for (long step = 0; step < options.steps; ++step) {
        if (step % EPISODE == 0) robot.set_pos(home);
        const Speeds v = speeds(0, step);
        const double ahead = 0.5e3 * STEP_S * (v.left + v.right), apart = 0.5e3 * STEP_S * turn * (v.right - v.left);
        if (options.check) {
            robot.reinit();
            sums.from(0, 1e-3 * robot.get_pos().x(), 1e-3 * robot.get_pos().y());
        }
        // Not sticky: where it would hit a wall it stays, but turns.
        robot.move(float(ahead - apart), float(ahead + apart), map, false);
        if (options.check) {
            sums.to(0, 1e-3 * robot.get_pos().x(), 1e-3 * robot.get_pos().y(), robot.get_collision());
            for (const auto& laser : robot.get_lasers()) sums.ray(1e-3 * laser.get_dist(), laser.get_dist() >= 0);
        }
    }
    if (options.check) sums.print();
    return 0;
}
