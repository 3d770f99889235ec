// What the drivers share: the world files, the wheel speeds of every robot and step (the same bits as
// evswarm's load `peers`), and the figures that show whether robots move, sense and bump.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

// The e-puck as evswarm has it (preset `thesis`).
constexpr double TOP_SPEED_M_S = 6.28 * 0.0205;
constexpr double AXLE_M = 0.052;
constexpr double BODY_RADIUS_M = 0.037;
constexpr double STEP_S = 0.064;
constexpr double SENSOR_RANGE_M = 0.070;
// Where the eight sensors sit: ahead, to the left, direction.
constexpr double MOUNTS[8][3] = {
    {0.030, -0.010, -0.3008}, {0.022, -0.025, -0.8008}, {0.000, -0.031, -1.5708},
    {-0.030, -0.015, -2.6440}, {-0.030, 0.015, 2.6392}, {0.000, 0.031, 1.5708},
    {0.022, 0.025, 0.7992},   {0.030, 0.010, 0.2992},
};
// A lone robot goes back to its start after so many steps, as in evswarm's load.
constexpr long EPISODE = 2000;

struct Wall { double ax, ay, bx, by; };
struct Start { double x, y, heading; };

struct Arena {
    double width = 0, height = 0;
    std::vector<Wall> walls; // the inner ones
    std::vector<Start> starts;
};

// The numbers between two places of a text, names of fields left out.
inline std::vector<double> numbers(const std::string& text, size_t from, size_t to) {
    std::vector<double> found;
    while (from < to) {
        if (text[from] == '"') {
            from = text.find('"', from + 1) + 1;
        } else if (std::strchr("-0123456789", text[from])) {
            char* end = nullptr;
            found.push_back(std::strtod(text.c_str() + from, &end));
            from = end - text.c_str();
        } else {
            ++from;
        }
    }
    return found;
}

inline size_t place(const std::string& text, const char* field) {
    size_t at = text.find(std::string("\"") + field + "\"");
    if (at == std::string::npos) {
        std::cerr << "no field " << field << "\n";
        std::exit(2);
    }
    return at;
}

inline Arena read_arena(const std::string& path) {
    std::ifstream file(path);
    std::stringstream all;
    all << file.rdbuf();
    const std::string text = all.str();
    const size_t width = place(text, "width_m"), height = place(text, "height_m");
    const size_t walls = place(text, "walls_m"), starts = place(text, "starts");
    Arena arena;
    arena.width = numbers(text, width, height).at(0);
    arena.height = numbers(text, height, walls).at(0);
    const auto w = numbers(text, walls, starts), s = numbers(text, starts, text.size());
    for (size_t i = 0; i + 3 < w.size(); i += 4) arena.walls.push_back({w[i], w[i + 1], w[i + 2], w[i + 3]});
    for (size_t i = 0; i + 2 < s.size(); i += 3) arena.starts.push_back({s[i], s[i + 1], s[i + 2]});
    return arena;
}

inline uint64_t mix64(uint64_t x) {
    x = (x ^ (x >> 27)) * 0x3C79AC492BA7B653u;
    x = (x ^ (x >> 33)) * 0x1C69B3F74AC4AE35u;
    return x ^ (x >> 27);
}

struct Speeds { double left, right; }; // metres a second

// New wheel speeds, uniform in [-0.4, 1] of the top speed.
inline Speeds speeds(uint64_t robot, uint64_t step) {
    const uint64_t bits = mix64(mix64((step * 0x9E3779B97F4A7C15u) ^ robot) + robot);
    const auto speed = [](uint32_t half) {
        return (1.4 * ((half >> 8) * (1.0 / 16777216.0)) - 0.4) * TOP_SPEED_M_S;
    };
    return {speed(static_cast<uint32_t>(bits)), speed(static_cast<uint32_t>(bits >> 32))};
}

// The command line: WORLD.json STEPS [--check] [NAME=VALUE]...
struct Options {
    std::string world;
    long steps = 0;
    bool check = false;
    std::vector<std::string> rest;

    Options(int argc, char** argv) {
        if (argc < 3) {
            std::cerr << "usage: " << argv[0] << " WORLD.json STEPS [--check] [NAME=VALUE]...\n";
            std::exit(2);
        }
        world = argv[1];
        steps = std::atol(argv[2]);
        for (int i = 3; i < argc; ++i) {
            if (std::strcmp(argv[i], "--check") == 0) check = true;
            else rest.push_back(argv[i]);
        }
    }

    std::string value(const std::string& name, const std::string& otherwise) const {
        for (const auto& option : rest)
            if (option.rfind(name + "=", 0) == 0) return option.substr(name.size() + 1);
        return otherwise;
    }
};

// What a check adds up over robots and steps.
struct Sums {
    long robot_steps = 0, contacts = 0, rays = 0, seen = 0;
    double moved_m = 0, ray_m = 0;
    std::vector<double> before, way;

    explicit Sums(size_t robots) : before(2 * robots), way(robots) {}

    void from(size_t robot, double x_m, double y_m) {
        before[2 * robot] = x_m;
        before[2 * robot + 1] = y_m;
    }

    void to(size_t robot, double x_m, double y_m, bool contact) {
        const double moved = std::hypot(x_m - before[2 * robot], y_m - before[2 * robot + 1]);
        moved_m += moved;
        way[robot] += moved;
        contacts += contact;
        ++robot_steps;
    }

    void ray(double length_m, bool sees) {
        ray_m += sees ? std::fmin(length_m, SENSOR_RANGE_M) : SENSOR_RANGE_M;
        seen += sees;
        ++rays;
    }

    void print() const {
        long still = 0;
        for (double w : way) still += w < 0.001;
        std::printf("moved_mm %.3f contact %.4f ray_mm %.2f seen %.4f still %ld\n",
                    1e3 * moved_m / robot_steps, double(contacts) / robot_steps,
                    1e3 * ray_m / rays, double(seen) / rays, still);
    }
};
