#pragma once

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

namespace terravox::test {

/// A survey of six squares side by side, two rows of three, each of 160 x 160 m in a file of its
/// own: hills, houses and trees; a lake that lies in the three northern ones; a hall in the
/// south-west under which no ground was seen for 76 m. Borders lie within patches.
class Patchwork {
public:
    static constexpr int kAcross = 3;
    static constexpr int kDown = 2;
    static constexpr int kSide_m = 160;
    using Change = std::function<void(Cloud::Point&)>;

    Patchwork() {
        for (int i = 0; i < kAcross * kDown; ++i)
            write(i);
    }
    /// The same files elsewhere, with the times that they had.
    Patchwork(const Patchwork& other) {
        namespace fs = std::filesystem;
        fs::copy(other.root(), root(), fs::copy_options::recursive);
        for (const auto& entry : fs::recursive_directory_iterator(other.root()))
            if (entry.is_regular_file())
                fs::last_write_time(root() / fs::relative(entry.path(), other.root()),
                                    fs::last_write_time(entry.path()));
    }
    Patchwork& operator=(const Patchwork&) = delete;

    [[nodiscard]] std::filesystem::path folder() const { return m_folder.path() / "lidar"; }
    [[nodiscard]] std::filesystem::path square(int i) const {
        return folder() / ("s" + std::to_string(i) + ".las");
    }
    [[nodiscard]] std::filesystem::path images() const { return m_folder.path() / "images"; }
    [[nodiscard]] const std::filesystem::path& root() const { return m_folder.path(); }

    /// (Re)writes a square. @param index beyond the six: one more to the east of the first row
    /// @param change is applied to each point
    void write(int index, const Change& change = {}) {
        const bool extra = index >= kAcross * kDown;
        const double east = (extra ? kAcross + index - kAcross * kDown : index % kAcross) * kSide_m;
        const double north = (extra ? 1 : index / kAcross) * kSide_m;
        Cloud cloud;
        std::mt19937 random(static_cast<unsigned>(index) + 1);
        const auto unit = [&] { return static_cast<double>(random() % 1'000'000) / 1'000'000; };
        for (int i = 0; i < 80'000; ++i) {
            const double e = east + 0.02 + unit() * (kSide_m - 0.04);
            const double n = north + 0.02 + unit() * (kSide_m - 0.04);
            const double noise = (unit() - 0.5) * 0.1;
            add(cloud, e, n, noise, unit());
        }
        Cloud changed;
        for (Cloud::Point p : cloud.points()) {
            if (change)
                change(p);
            if (p.source_class != kGone)
                changed.add(p.east, p.north, p.height, p.source_class, p.rgb);
        }
        std::filesystem::create_directories(folder());
        changed.write(square(index));
    }
    static constexpr std::uint8_t kGone = 200;  ///< a class for points that a change takes away

    /// An image of one colour over a rectangle, metres from the corner.
    void image(const std::string& name, double east, double north, double width, double height,
               std::array<int, 3> colour) const {
        std::filesystem::create_directories(images());
        write_one_colour(images() / name, east, north, width, height, colour);
    }

    [[nodiscard]] voxelize::LidarWorldOptions options() const {
        auto out = OpenWorld::with(folder());
        if (std::filesystem::exists(images()))
            out.orthophotos = {images()};
        return out;
    }

private:
    static double ground(double e, double n) {
        return 300 + 6 * std::sin(e / 31) + 5 * std::cos(n / 19);
    }
    static bool lake(double e, double n) {
        return std::abs(n - 250 - 5 * std::sin(e / 20)) < 14 && e > 20 && e < 440;
    }
    static bool hall(double e, double n) { return std::abs(e - 75) < 38 && std::abs(n - 75) < 38; }

    static void add(Cloud& cloud, double e, double n, double noise, double dice) {
        if (lake(e, n)) {
            if (dice < 0.1)
                cloud.add(e, n, 292 + noise, 9);
        } else if (hall(e, n)) {
            cloud.add(e, n, 320 + noise, 6);
        } else if (std::fmod(e, 50) > 38 && std::fmod(n, 60) > 48) {
            cloud.add(e, n, ground(e, n) + 8 + noise, 6);
        } else {
            cloud.add(e, n, ground(e, n) + noise, 2);
            if (std::sin(e / 5) * std::sin(n / 5) > 0.7)
                cloud.add(e, n, ground(e, n) + 2 + dice * 9, 5);
        }
    }

    TemporaryFolder m_folder;
};

// What tests change of a patchwork, or of the way in which it is opened.
using Options = voxelize::LidarWorldOptions;
using Change = std::function<void(Patchwork&, Options&)>;

/// Changes each point of a square.
inline Change in_square(int square, const Patchwork::Change& change) {
    return [=](Patchwork& p, Options&) { p.write(square, change); };
}
inline Change image(const char* name, std::array<double, 4> rect, std::array<int, 3> colour) {
    return
        [=](Patchwork& p, Options&) { p.image(name, rect[0], rect[1], rect[2], rect[3], colour); };
}
inline Change without(const char* file) {
    return [=](Patchwork& p, Options&) { std::filesystem::remove(p.root() / file); };
}
inline Change with_file(const char* file, const char* text) {
    return [=](Patchwork& p, Options&) { std::ofstream(p.root() / file) << text; };
}
inline Change rename_west(const char* to) {
    return [=](Patchwork& p, Options&) {
        std::filesystem::rename(p.images() / "west.tif", p.images() / to);
    };
}
inline Change settings(const char* lines) {
    return [=](Patchwork& p, Options& o) {
        o.settings = p.root() / "s.toml";
        std::ofstream(o.settings) << lines;
    };
}
inline Change classes(const char* lines) {
    return [=](Patchwork& p, Options& o) {
        o.classes = (p.root() / "c.toml").string();
        std::ofstream(o.classes) << lines;
    };
}
inline Change palette(const char* lines) {
    return [=](Patchwork& p, Options& o) {
        const std::string file = (p.root() / "p.toml").string();
        std::ofstream(file) << lines;
        settings(("[specialization]\npalette = \"" + file + "\"\n").c_str())(p, o);
    };
}

/// What a server keeps of a world: every box with what it was made of.
struct Kept {
    struct One {
        std::uint64_t checksum = 0;  ///< 0 = air
        voxel::InputExtent reach;
        voxel::Fingerprint fingerprint{};
    };
    std::map<voxel::BoxKey, One> boxes;
    voxel::WorldInfo info;
};

inline std::vector<voxel::BoxKey> keys_of_all_levels(const voxel::WorldInfo& info) {
    std::vector<voxel::BoxKey> out;
    for (int level = 0; level < info.levels; ++level)
        for (const auto& key : all_keys(info, level))
            out.push_back(key);
    return out;
}

inline Kept keep(voxelize::LidarWorld& world, const std::vector<voxel::BoxKey>& keys) {
    Kept out;
    out.info = world.info();
    for (const auto& key : keys) {
        const auto made = world.box_with_inputs(key);
        out.boxes[key] = {made.box ? made.box->checksum() : 0, made.reach,
                          world.fingerprint(made.reach)};
    }
    return out;
}
inline Kept keep(voxelize::LidarWorld& world) {
    return keep(world, keys_of_all_levels(world.info()));
}

}  // namespace terravox::test
