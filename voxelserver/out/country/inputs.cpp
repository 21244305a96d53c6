#include "voxelserver/out/country/inputs.hpp"

#include <algorithm>
#include <map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/image_files.hpp"
#include "voxelserver/data/pointcloud/formats/open.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/square_sample.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"

namespace terravox::country {
namespace {

namespace fs = std::filesystem;

/// All files that the options name, also those that cannot be opened.
voxelize::LidarWorldOptions make_options(const worlds::WorldOptions& world) {
    for (const std::string& input : world.inputs)
        if (!worlds::is_store(input) && !worlds::is_lidar(input))
            throw util::UsageError("plan the country: " + input +
                                   "; allowed: " + std::string(worlds::kLidarInputs) +
                                   ", folders of them, or the grabber's store");
    return worlds::lidar_world_options(world);
}

std::string make_identity(const fs::path& file) {
    return voxel::to_hex(voxel::file_identity(file, "point cloud"));
}

std::uint64_t measure_size(const fs::path& file) {
    std::error_code failed;
    const auto size = fs::file_size(file, failed);
    return failed ? 0 : size;
}

std::vector<PlannedFile> list_images(const voxelize::LidarWorldOptions& options) {
    std::vector<PlannedFile> out;
    if (options.orthophotos.empty())
        return out;
    for (const fs::path& file : imagery::orthophoto_files(options.orthophotos))
        out.push_back({file, measure_size(file), 0, voxel::to_hex(imagery::image_identity(file))});
    return out;
}

void add_missing_of_store(const std::string& folder, std::vector<MissingSquare>& missing) {
    for (const store::StoredSquare& square : store::read_grabber_store(folder).squares)
        if (square.state != store::StoredState::kFetched)
            missing.push_back({square.name, square.error.empty() ? std::string("the store says: ") +
                                                                       store::to_name(square.state)
                                                                 : square.error});
}

using Named = std::map<std::string, const PlannedFile*>;

Named by_name(const std::vector<PlannedFile>& files) {
    Named out;
    for (const PlannedFile& file : files)
        out.emplace(file.file.lexically_normal().string(), &file);
    return out;
}

/// @param now files that are there
/// @param identity of a file that is there
template <class Identity>
std::vector<FileChange> compare(const std::vector<PlannedFile>& then,
                                const std::vector<fs::path>& now, const Identity& identity) {
    std::vector<FileChange> out;
    Named planned = by_name(then);
    for (const fs::path& file : now) {
        const auto found = planned.find(file.lexically_normal().string());
        if (found == planned.end()) {
            out.push_back({FileChange::Kind::kNew, file, {}});
            continue;
        }
        try {
            if (identity(file) != found->second->identity)
                out.push_back({FileChange::Kind::kChanged, file, {}});
        } catch (const util::Error& e) {
            out.push_back({FileChange::Kind::kUnreadable, file, e.what()});
        }
        planned.erase(found);
    }
    for (const auto& [name, file] : planned)
        out.push_back({FileChange::Kind::kGone, file->file, {}});
    return out;
}

}  // namespace

std::string look_at(PlannedFile& file) {
    try {
        const auto source = pointcloud::open_point_source(file.file);
        // Opening the world reads the same points, and fails where they are damaged.
        (void)source->sample(voxelize::kSampledPoints);
        file.points = source->info().point_count;
        file.bytes = measure_size(file.file);
        file.identity = make_identity(file.file);
        return "";
    } catch (const util::Error& e) {
        return e.what();
    }
}

Inputs look_at_inputs(const worlds::WorldOptions& world) {
    const voxelize::LidarWorldOptions options = make_options(world);
    Inputs out;
    for (const fs::path& file : voxelize::lidar_files(options))
        out.squares.push_back({file, 0, 0, ""});
    std::vector<std::string> reasons(out.squares.size());
    thread::parallel_for(out.squares.size(), world.threads,
                         [&](std::size_t i) { reasons[i] = look_at(out.squares[i]); });
    std::vector<PlannedFile> whole;
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        if (reasons[i].empty()) {
            whole.push_back(std::move(out.squares[i]));
            continue;
        }
        const fs::path& file = out.squares[i].file;
        out.missing.push_back({file.stem().string(), reasons[i]});
        out.left_out.push_back(file);
    }
    out.squares = std::move(whole);
    if (out.squares.empty())
        throw util::Error("plan the country: no file can be opened: " + out.missing.front().reason);
    for (const std::string& input : world.inputs)
        if (worlds::is_store(input))
            add_missing_of_store(input, out.missing);
    std::sort(out.missing.begin(), out.missing.end(),
              [](const MissingSquare& a, const MissingSquare& b) { return a.name < b.name; });
    out.images = list_images(options);
    return out;
}

std::string to_text(const FileChange& change) {
    switch (change.kind) {
        case FileChange::Kind::kNew: return change.file.string() + " is new";
        case FileChange::Kind::kChanged: return change.file.string() + " has changed";
        case FileChange::Kind::kGone: return change.file.string() + " is gone";
        case FileChange::Kind::kUnreadable: break;
    }
    return change.error;
}

InputChanges compare_inputs(const Plan& plan, const worlds::WorldOptions& world) {
    const voxelize::LidarWorldOptions options = make_options(world);
    std::vector<fs::path> images;
    if (!options.orthophotos.empty())
        images = imagery::orthophoto_files(options.orthophotos);
    return {compare(plan.squares, voxelize::lidar_files(options), make_identity),
            compare(plan.images, images, [](const fs::path& file) {
                return voxel::to_hex(imagery::image_identity(file));
            })};
}

std::vector<std::string> changes_since(const Plan& plan) {
    InputChanges changes;
    try {
        changes = compare_inputs(plan, plan.world);
    } catch (const util::Error& e) {
        return {e.what()};
    }
    std::vector<std::string> out;
    for (const auto* list : {&changes.squares, &changes.images})
        for (const FileChange& change : *list)
            out.push_back(to_text(change));
    return out;
}

void check_program(const Plan& plan, const std::string& attempt) {
    if (plan.program != kVersion || plan.box_recipe != voxelize::kBoxRecipe)
        throw util::Error(attempt + ": the plan was made by version " + plan.program + " (boxes " +
                          std::to_string(plan.box_recipe) + "), this program is version " +
                          kVersion + " (boxes " + std::to_string(voxelize::kBoxRecipe) +
                          "); allowed: the same");
}

void check_current(const Plan& plan, const std::string& attempt) {
    check_program(plan, attempt);
    const std::vector<std::string> changes = changes_since(plan);
    if (changes.empty())
        return;
    std::string more;
    if (changes.size() > 1)
        more = ", and " + std::to_string(changes.size() - 1) + " more";
    throw util::Error(attempt +
                      ": the data have changed since the plan was made: " + changes.front() + more +
                      "; plan again, or where its archive is finished: terravox country patch");
}

}  // namespace terravox::country
