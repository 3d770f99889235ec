// roborobo4 without display or log. Its project `Dummy` is given here, with a controller that draws
// wheel speeds; the arena is drawn into the image that roborobo4 takes for the world.
#include <unistd.h>

#include <map>

#include "Agents/Robot.h"
#include "Config/DummyConfigurationLoader.h"
#include "Controllers/Controller.h"
#include "Observers/AgentObserver.h"
#include "Observers/WorldObserver.h"
#include "RoboroboMain/roborobo.h"
#include "World/World.h"
#include "WorldModels/RobotWorldModel.h"

#include "common.h"

namespace {

double pixel_m = 0.015;
constexpr int BORDER = 3; // pixels of outer wall

// A place of the arena in pixels, of which pixel i has its middle at i.
double pixels(double metres) { return metres / pixel_m - 0.5 + BORDER; }
double metres(double pixel) { return (pixel + 0.5 - BORDER) * pixel_m; }

class Driven : public Controller {
  public:
    using Controller::Controller;
    void reset() override {}
    void step() override {
        const Speeds v = speeds(_wm->getId(), steps++);
        _wm->_desiredTranslationalValue = 0.5 * (v.left + v.right) * STEP_S / pixel_m;
        _wm->_desiredRotationalVelocity = (v.right - v.left) * STEP_S / AXLE_M * 180.0 / M_PI;
    }

  private:
    uint64_t steps = 0;
};

class Observed : public AgentObserver {
  public:
    using AgentObserver::AgentObserver;
    void reset() override {}
    void stepPre() override {}
};

class Nothing : public WorldObserver {
  public:
    using WorldObserver::WorldObserver;
};

void put(Robot& robot, const Start& start) {
    auto wm = robot.getWorldModel();
    if (robot.isRegistered()) robot.unregisterRobot();
    wm->_xReal = pixels(start.x);
    wm->_yReal = pixels(start.y);
    wm->_agentAbsoluteOrientation = start.heading * 180.0 / M_PI;
    wm->_agentAbsoluteLinearSpeed = 0;
    robot.setCoord(int(wm->_xReal + 0.5), int(wm->_yReal + 0.5));
    robot.registerRobot();
}

void draw(const Arena& arena, int width, int height, const std::string& path, bool walls) {
    SDL_Surface* image = SDL_CreateRGBSurfaceWithFormat(0, width, height, 32, SDL_PIXELFORMAT_ARGB8888);
    const auto dot = [&](int x, int y, Uint32 colour) {
        if (x >= 0 && y >= 0 && x < width && y < height)
            static_cast<Uint32*>(image->pixels)[y * (image->pitch / 4) + x] = colour;
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool border = x < BORDER || y < BORDER || x >= width - BORDER || y >= height - BORDER;
            dot(x, y, walls && border ? 0xFF000000 : 0xFFFFFFFF);
        }
    for (const Wall& wall : arena.walls) {
        if (!walls) break;
        const int dots = 2 + int(4 * std::hypot(wall.bx - wall.ax, wall.by - wall.ay) / pixel_m);
        for (int i = 0; i <= dots; ++i) {
            const double t = double(i) / dots;
            dot(int(pixels(wall.ax + t * (wall.bx - wall.ax)) + 0.5),
                int(pixels(wall.ay + t * (wall.by - wall.ay)) + 0.5), 0xFF000000);
        }
    }
    if (SDL_SaveBMP(image, path.c_str()) != 0) {
        std::cerr << "writing " << path << ": " << SDL_GetError() << "\n";
        std::exit(1);
    }
    SDL_FreeSurface(image);
}

} // namespace

DummyConfigurationLoader::DummyConfigurationLoader() {}
DummyConfigurationLoader::~DummyConfigurationLoader() {}
std::shared_ptr<WorldObserver> DummyConfigurationLoader::make_WorldObserver(World* world) {
    return std::make_shared<Nothing>(world);
}
std::shared_ptr<RobotWorldModel> DummyConfigurationLoader::make_RobotWorldModel() {
    return std::make_shared<RobotWorldModel>();
}
std::shared_ptr<AgentObserver> DummyConfigurationLoader::make_AgentObserver(std::shared_ptr<RobotWorldModel> wm) {
    return std::make_shared<Observed>(wm);
}
std::shared_ptr<Controller> DummyConfigurationLoader::make_Controller(std::shared_ptr<RobotWorldModel> wm) {
    return std::make_shared<Driven>(wm);
}

int main(int argc, char** argv) {
    const Options options(argc, argv);
    const Arena arena = read_arena(options.world);
    const std::string source = options.value("source", "."), folder = options.value("scratch", ".");
    const int pixel_mm = std::atoi(options.value("pixel_mm", "15").c_str());
    if (pixel_mm != 15 && pixel_mm != 5) {
        std::cerr << "pixel_mm is 15 or 5: a robot is 5 or 15 pixels wide\n";
        return 2;
    }
    pixel_m = pixel_mm * 1e-3;
    const int width = int(std::ceil(arena.width / pixel_m - 1e-6)) + 2 * BORDER;
    const int height = int(std::ceil(arena.height / pixel_m - 1e-6)) + 2 * BORDER;
    const std::string mine = folder + "/roborobo4-" + std::to_string(getpid());
    draw(arena, width, height, mine + "-walls.bmp", true);
    draw(arena, width, height, mine + "-ground.bmp", false);

    const std::string robot = pixel_mm == 15 ? "/data/minirobot" : "/data/robot15";
    std::map<std::string, std::string> own = {
        {"ConfigurationLoaderObjectName", "DummyConfigurationLoader"},
        {"gInitialNumberOfRobots", std::to_string(arena.starts.size())},
        {"gRobotRegisterAtInit", "false"},
        {"gNbOfLandmarks", "0"},
        {"gNbOfPhysicalObjects", "0"},
        {"gBatchMode", "true"},
        {"gDisplayMode", "2"},
        {"gVerbose", "false"},
        {"gRandomSeed", "1"},
        {"gLogFilename", "roborobo4-" + std::to_string(getpid()) + ".log"},
        {"gArenaWidth", std::to_string(width)},
        {"gArenaHeight", std::to_string(height)},
        {"gMaxTranslationalSpeed", std::to_string(TOP_SPEED_M_S * STEP_S / pixel_m)},
        // Wheels take up any speed at once.
        {"gMaxTranslationalDeltaValue", std::to_string(2 * TOP_SPEED_M_S * STEP_S / pixel_m)},
        {"gMaxRotationalSpeed", "30"},
        {"gSensorRange", std::to_string(std::lround(SENSOR_RANGE_M / pixel_m))},
        {"gForegroundImageFilename", mine + "-walls.bmp"},
        {"gEnvironmentImageFilename", mine + "-walls.bmp"},
        {"gBackgroundImageFilename", mine + "-ground.bmp"},
        {"gFootprintImageFilename", mine + "-ground.bmp"},
        {"gRobotMaskImageFilename", source + robot + (pixel_mm == 15 ? "-mask-edgesOnly.bmp" : "-mask.bmp")},
        {"gRobotSpecsImageFilename", source + robot + "-specs-8sensors.bmp"},
    };
    // The rest is as in roborobo4's own benchmark; a name may stand once only.
    std::ofstream properties(mine + ".properties");
    std::ifstream benchmark(source + "/config/benchmark.properties");
    for (std::string line; std::getline(benchmark, line);) {
        const std::string name = line.substr(0, line.find_first_of(" ="));
        if (name.rfind("g", 0) == 0 || name == "VisibleLandmarks" || name == "SlowMotionMode")
            own.emplace(name, line.substr(line.find('=') + 1));
    }
    for (const auto& [name, value] : own) properties << name << " = " << value << "\n";
    properties.close();

    setenv("SDL_VIDEODRIVER", "dummy", 1);
    setenv("SDL_AUDIODRIVER", "dummy", 1);
    gPropertiesFilename = mine + ".properties";
    gLogDirectoryname = folder;
    gLogDirectoryname_commandlineargument = true;
    gBatchMode_commandlineargument = gBatchMode = true;
    gVerbose_commandlineargument = true;
    gVerbose = false;
    gDisplayMode = 2;
    initRoborobo();
    for (size_t i = 0; i < arena.starts.size(); ++i) put(*gRobots[i], arena.starts[i]);
    for (const char* end : {"-walls.bmp", "-ground.bmp", ".properties", ".log"})
        unlink((mine + end).c_str());

    const bool alone = arena.starts.size() == 1;
    Sums sums(arena.starts.size());
    for (long step = 0; step < options.steps;) {
        if (alone && step % EPISODE == 0) put(*gRobots[0], arena.starts[0]);
        if (!options.check) {
            const long block = std::min(options.steps - step, EPISODE);
            runRoborobo(block);
            step += block;
            continue;
        }
        for (size_t i = 0; i < gRobots.size(); ++i) {
            auto wm = gRobots[i]->getWorldModel();
            sums.from(i, metres(wm->_xReal), metres(wm->_yReal));
        }
        runRoborobo(1);
        ++step;
        for (size_t i = 0; i < gRobots.size(); ++i) {
            auto wm = gRobots[i]->getWorldModel();
            sums.to(i, metres(wm->_xReal), metres(wm->_yReal),
                    wm->_actualTranslationalValue == 0 && wm->_desiredTranslationalValue != 0);
            for (int k = 0; k < wm->_cameraSensorsNb; ++k)
                sums.ray(wm->getCameraSensorValue(k, SENSOR_DISTANCEVALUE) * pixel_m,
                         wm->getCameraSensorValue(k, SENSOR_OBJECTVALUE) != -1);
        }
    }
    if (options.check) sums.print();
    std::fflush(stdout);
    // Its own end takes images apart that are no part of a step.
    _exit(0);
}
