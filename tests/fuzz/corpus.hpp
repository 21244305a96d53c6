#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"
#include "tests/common/voxel/synthetic_world.hpp"

/// What makes the inputs that corpora begin with: small valid ones, by the project's own writers.
namespace terravox::fuzz {

template <class Range>
std::string chars(const Range& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The inputs of one target.
class Corpus {
public:
    Corpus(const std::filesystem::path& folder, const std::string& target)
        : m_folder(folder / target) {
        std::filesystem::create_directories(m_folder);
    }
    void add(const std::string& name, const std::string& bytes) const {
        std::ofstream out(m_folder / name, std::ios::binary);
        out << bytes;
        out.close();
        if (!out)
            throw util::Error("write " + (m_folder / name).string() + ": it cannot be written");
    }
    void add_file(const std::filesystem::path& file) const {
        std::ifstream in(file, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        if (!in)
            throw util::Error("read " + file.string() + ": it cannot be read");
        add(file.filename().string(), bytes);
    }
    [[nodiscard]] std::filesystem::path path(const std::string& name) const {
        return m_folder / name;
    }

private:
    std::filesystem::path m_folder;
};

[[nodiscard]] inline std::shared_ptr<const voxel::Box> small_box(const voxel::BoxKey& key) {
    voxel::BoxBuilder builder;
    for (int x = 0; x < 8; ++x)
        builder.add(x, 3 + x, 3, 5 + x, x % 2 == 0);
    return builder.build(key, test::SyntheticWorld::attr_at);
}

[[nodiscard]] inline voxel::WorldInfo small_info() {
    voxel::WorldInfo info;
    info.title = "small";
    info.bounds = {{-64, 0, -64}, {64, 256, 64}};
    info.levels = 2;
    info.crs = "EPSG:3794";
    info.centre = geo::MapPlace{46, 14};
    return info;
}

}  // namespace terravox::fuzz
