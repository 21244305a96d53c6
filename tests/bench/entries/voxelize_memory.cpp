#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "tests/bench/entries/data_sets.hpp"
#include "tests/bench/moved_square.hpp"

namespace terravox::bench::voxelize_memory_entry {
namespace {

constexpr double kLimit_mib = 700;
/// Of the limit, left to all but the world's caches: program and libraries, readers and what each
/// thread has at work.
constexpr double kAllowance_mib = 200;

/// n x n copies of the square side by side, 1 km apart. Those that are there already stay.
std::filesystem::path make_squares(const Context& c, int n) {
    const auto folder = c.scratch / ("squares-" + std::to_string(n));
    std::filesystem::create_directories(folder);
    for (int north = 0; north < n; ++north)
        for (int east = 0; east < n; ++east)
            copy_moved(square().paths(c).front(),
                       folder / ("TM_" + std::to_string(462 + east) + "_" +
                                 std::to_string(101 + north) + ".laz"),
                       1000.0 * east, 1000.0 * north);
    return folder;
}

Entry entry_for(int n) {
    const std::string size = std::to_string(n) + "x" + std::to_string(n);
    Entry out;
    out.name = "voxelize/memory/" + size;
    out.measures = "peak memory and speed of a program that asks for every box of " + size +
                   " squares once, block by block";
    out.work = size + " copies of " + square().facts + "; caches of " +
               std::to_string(static_cast<int>(kLimit_mib - kAllowance_mib)) + " MiB, N threads";
    out.missing = [](const Context& c) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(c.programs / "terravox-bench-stream", ignored))
            return "no terravox-bench-stream in " + c.programs.string();
        return square().missing(c);
    };
    out.exact = out.only_by_name = true;
    out.prepare = [n](const Context& c) -> Body {
        const auto folder = make_squares(c, n);
        return [folder, &c](Readings& readings) {
            const auto output = c.scratch / "stream.txt";
            const ChildOutcome run =
                c.children.run({(c.programs / "terravox-bench-stream").string(), folder.string(),
                                "--crs", square().crs, "--classes", square().classes, "--threads",
                                std::to_string(c.threads), "--memory-mib",
                                std::to_string(static_cast<int>(kLimit_mib - kAllowance_mib)),
                                "--cache-dir", (c.scratch / "stream-cache").string()},
                               output);
            if (run.exit_code != 0)
                throw util::Error("stream the boxes: " + last_line(output));
            const auto said = nlohmann::json::parse(last_line(output));
            const auto points = said.at("points").get<double>();
            readings.add("points", "Mpoint", points / 1e6);
            readings.add("boxes", "boxes", said.at("boxes").get<double>());
            readings.add("peak memory", "MiB", static_cast<double>(run.peak_kib) / 1024,
                         at_most(kLimit_mib));
            readings.add("wall", "s", run.wall_s);
            readings.add("CPU", "s", run.user_s + run.system_s);
            readings.add("open", "s", said.at("open_s").get<double>());
            readings.add("rate", "Mpoint/s", points / run.wall_s / 1e6);
        };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{entry_for(2), entry_for(3), entry_for(5), entry_for(10)};
});

}  // namespace
}  // namespace terravox::bench::voxelize_memory_entry
