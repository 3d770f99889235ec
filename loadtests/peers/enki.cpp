// Enki: its e-puck with eight infra-red sensors (three rays each) and its physics, centimetres.
#include <array>

#include <enki/PhysicalEngine.h>
#include <enki/robots/e-puck/EPuck.h>

#include "common.h"

namespace {

class Driven : public Enki::EPuck {
  public:
    bool contact = false;
    // The number of the turret's capability holds the bit of the basic sensors': with these it would
    // scan all around too, so the eight are added here.
    Driven() : EPuck(CAPABILITY_NONE) {
        for (auto* sensor : sensors()) addLocalInteraction(sensor);
        // As our robot: wheels that far apart, slipping by a tenth.
        distBetweenWheels = 100 * AXLE_M;
        maxSpeed = 100 * TOP_SPEED_M_S * 1.1;
        noiseAmount = 0.1;
    }
    std::array<Enki::IRSensor*, 8> sensors() {
        return {&infraredSensor0, &infraredSensor1, &infraredSensor2, &infraredSensor3,
                &infraredSensor4, &infraredSensor5, &infraredSensor6, &infraredSensor7};
    }
    void collisionEvent(Enki::PhysicalObject*) override { contact = true; }
};

void put(Driven& robot, const Start& start) {
    robot.pos = Enki::Point(100 * start.x, 100 * start.y);
    robot.angle = start.heading;
    robot.speed = Enki::Vector(0, 0);
    robot.angSpeed = 0;
}

} // namespace

int main(int argc, char** argv) {
    const Options options(argc, argv);
    const Arena arena = read_arena(options.world);
    Enki::World world(100 * arena.width, 100 * arena.height);
    world.setRandomSeed(1);
    for (const Wall& wall : arena.walls) {
        auto* object = new Enki::PhysicalObject();
        object->setRectangular(100 * std::hypot(wall.bx - wall.ax, wall.by - wall.ay), 0.1, 10, -1);
        object->pos = Enki::Point(50 * (wall.ax + wall.bx), 50 * (wall.ay + wall.by));
        object->angle = std::atan2(wall.by - wall.ay, wall.bx - wall.ax);
        object->setColor(Enki::Color::gray);
        world.addObject(object);
    }
    std::vector<Driven*> robots;
    for (const Start& start : arena.starts) {
        robots.push_back(new Driven());
        put(*robots.back(), start);
        world.addObject(robots.back());
    }

    Sums sums(robots.size());
    for (long step = 0; step < options.steps; ++step) {
        if (robots.size() == 1 && step % EPISODE == 0) put(*robots[0], arena.starts[0]);
        for (size_t i = 0; i < robots.size(); ++i) {
            const Speeds v = speeds(i, step);
            robots[i]->leftSpeed = 100 * v.left;
            robots[i]->rightSpeed = 100 * v.right;
            robots[i]->contact = false;
            if (options.check) sums.from(i, 0.01 * robots[i]->pos.x, 0.01 * robots[i]->pos.y);
        }
        world.step(STEP_S);
        if (!options.check) continue;
        for (size_t i = 0; i < robots.size(); ++i) {
            Driven& r = *robots[i];
            // Outer walls raise no event: what touches one stands at it.
            const double x = r.pos.x, y = r.pos.y, edge = r.getRadius() + 1e-9;
            const bool outer = x <= edge || y <= edge || world.w - x <= edge || world.h - y <= edge;
            sums.to(i, 0.01 * x, 0.01 * y, r.contact || outer);
            for (const auto* sensor : r.sensors()) {
                // The middle one of its three rays.
                sums.ray(0.01 * sensor->getRayDist(1), sensor->getRayDist(1) < 100 * SENSOR_RANGE_M);
            }
        }
    }
    if (options.check) sums.print();
    return 0;
}
