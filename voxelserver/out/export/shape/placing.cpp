#include "voxelserver/out/export/shape/placing.hpp"

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "common/voxel/side_car.hpp"

namespace terravox::exports {
namespace {

// The shortest text that reads back as the same number would depend on the library; 15 digits do
// not.
std::string number(double value) {
    return util::number_text(value, 15);
}

// One line: a title with a line break must not add a line to a header of lines.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20)
            c = ' ';
    return text;
}

}  // namespace

std::array<std::int32_t, 3> make_origin(const Part& part) noexcept {
    const auto middle = [&](std::size_t a) {
        const std::int64_t low = part.bounds.min[a];
        const std::int64_t high = part.bounds.max[a];
        return static_cast<std::int32_t>(low + (high - low) / 2);
    };
    return {middle(0), part.bounds.min[1], middle(2)};
}

std::vector<std::pair<std::string, std::string>> collect_facts(const Job& job,
                                                               const std::string& axes) {
    const voxel::WorldInfo& world = job.world();
    const auto o = make_origin(job.part);
    std::vector<std::pair<std::string, std::string>> out;
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty())
            out.emplace_back(name, one_line(value));
    };
    add("title", world.title);
    add("crs", world.crs);
    add("offset", std::to_string(o[0]) + " " + std::to_string(o[1]) + " " + std::to_string(o[2]));
    add("voxel_m", number(job.voxel_m()));
    add("axes", axes);
    add("licence", world.licence);
    add("attribution", world.attribution);
    return out;
}

void finish_file(Job& job, util::AtomicFile& file) {
    util::AtomicFile side_car(file.target().string() + ".georef.json");
    // Written before either has its name: a file without its side-car would block the next run.
    try {
        voxel::write_side_car(
            side_car.temporary_path(),
            voxel::make_side_car(job.world(), job.part.level, make_origin(job.part)));
    } catch (const util::Error& e) {
        throw util::Error("write " + side_car.target().string() + ": " + e.what());
    }
    file.commit();
    side_car.commit();
    job.wrote(file.target());
    job.wrote(side_car.target());
}

void fail_for_nothing(const Job& job) {
    throw util::Error("write " + job.out.string() + ": the part holds nothing solid" +
                      (job.holes().empty() ? "" : " but holes") + "; nothing was written");
}

}  // namespace terravox::exports
