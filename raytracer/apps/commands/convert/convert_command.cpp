#include "raytracer/apps/commands/convert/convert_command.hpp"

#include <xxhash.h>
#include <algorithm>
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>

#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "common/util/version.hpp"
#include "common/voxel/log_damage.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "voxelserver/make/voxelize/world/dependent_columns.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"
#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/formats/formats.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;

void add_file(std::string& facts, const fs::path& file) {
    std::error_code failed;
    facts += '\n' + file.string() + ' ' + std::to_string(fs::file_size(file, failed));
    if (const auto time = fs::last_write_time(file, failed); !failed)
        facts += ' ' + std::to_string(time.time_since_epoch().count());
}

void add_files(std::string& facts, const fs::path& path) {
    std::error_code failed;
    std::vector<fs::path> files{path};
    for (fs::recursive_directory_iterator it(path, failed), end; !failed && it != end;
         it.increment(failed))
        files.push_back(it->path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        add_file(facts, file);
}

}  // namespace

std::string job_name(const WorldArguments& arguments, scene::Scene scene, const exports::Part& part,
                     const voxel::World& world, const std::string& form) {
    scene.processing = {};
    scene.world.memory_mib = scene::Scene::World{}.memory_mib;
    std::string facts = std::string(kVersion) + '\n' + scene::to_toml(scene) +
                        voxel::world_to_json(world.info()) + world.edition() + form;
    for (const auto* list : {&arguments.inputs, &arguments.orthophotos})
        for (const std::string& input : *list)
            add_files(facts, input);
    for (const char* folder : {"blocks", "classes", "palettes", "materials.toml", "voxelize.toml"})
        add_files(facts, util::config_dir() / folder);
    for (const std::string& file : {scene.world.settings, scene.world.classes})
        if (!file.empty())
            add_file(facts, file);
    for (std::size_t a = 0; a < 3; ++a)
        facts +=
            ' ' + std::to_string(part.bounds.min[a]) + ' ' + std::to_string(part.bounds.max[a]);
    return fmt::format("terravox {} {:016x}", form,
                       XXH64(facts.data(), facts.size(), static_cast<std::uint64_t>(part.level)));
}

namespace {

struct ConvertArguments {
    WorldArguments world;
    std::vector<std::string> paths;
    std::string to;
    std::string colours = "true";
    std::string up = "z";
    exports::WriteOptions write;
    std::string area;
    std::string heights;
    std::string shard;
    std::optional<std::string> squares;
    exports::Selection selection;
    int memory_mib = 1024;
    bool quiet = false;
};

/// @throws UsageError unless it is I/N, or empty
exports::ShardChoice parse_shard(const std::string& text) {
    if (text.empty())
        return {};
    const auto part = util::parse_part<int>(text);
    if (!part || part->second > exports::ShardChoice::kMost)
        throw util::UsageError("convert: --shard " + text +
                               "; allowed: I/N with I from 1 to N, N up to " +
                               std::to_string(exports::ShardChoice::kMost));
    return {part->first, part->second};
}

std::vector<exports::ColumnAt> columns_at(const std::vector<grid::PatchKey>& patches) {
    std::vector<exports::ColumnAt> out;
    for (const grid::PatchKey& at : patches)
        out.push_back({at.px, at.pz});
    return out;
}

/// What a change of the named squares makes anew.
exports::ChangedColumns columns_of_squares(voxel::World& world, const exports::Part& part,
                                           const std::vector<std::string>& names, int threads) {
    auto* const lidar = dynamic_cast<voxelize::LidarWorld*>(&world);
    if (lidar == nullptr)
        throw util::UsageError(
            "convert: --squares of a world without squares; allowed: LiDAR data and stores");
    const voxelize::DependentColumns found =
        voxelize::columns_that_depend_on(*lidar, voxelize::squares_named(*lidar, names), threads);
    exports::ChangedColumns out =
        exports::changed_columns(part, columns_at({found.dependent.begin(), found.dependent.end()}),
                                 columns_at(found.neighbours));
    if (out.replaced.empty())
        throw util::UsageError(
            "convert: --squares: none of them lies in the part; allowed: those "
            "that the archive shows");
    return out;
}

std::vector<std::string> names_in(const std::string& list) {
    std::vector<std::string> out;
    std::istringstream in(list);
    for (std::string name; std::getline(in, name, ',');)
        if (!name.empty())
            out.push_back(name);
    return out;
}

/// @return empty: the world has a title. Of data in files that is the name of a file or a folder,
/// which nobody has given to the world.
std::string make_title(const ConvertArguments& args, const fs::path& out) {
    if (!args.write.title.empty() || !worlds::find_kind(args.world.inputs.front()).takes_several)
        return args.write.title;
    return fs::weakly_canonical(out).filename().string();
}

util::ExitCode report(const exports::Job& job, const voxel::World& world, double seconds,
                      bool quiet) {
    const auto files = job.files();
    if (!quiet) {
        std::uint64_t bytes = 0;
        std::error_code failed;
        for (const fs::path& file : files)
            bytes += fs::file_size(file, failed);
        std::printf("%llu voxels, %.1f MiB in %zu files, %.1f s\n",
                    static_cast<unsigned long long>(job.voxels()),
                    static_cast<double>(bytes) / (1 << 20), files.size(), seconds);
        std::printf("wrote %s\n", job.out.c_str());
    }
    const auto holes = job.holes().size();
    const auto damage = world.damage();
    if (holes > 0)
        util::log_error("what was written has holes: {} boxes could not be loaded", holes);
    if (!damage.empty())
        voxel::log_damage(damage);
    return holes > 0 || !damage.empty() ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode run_convert(ConvertArguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    if (args.paths.size() < 2)
        throw util::UsageError("convert: " + std::to_string(args.paths.size()) +
                               " path; allowed: what to convert, then what to write");
    const auto start = std::chrono::steady_clock::now();
    const fs::path named = args.paths.back();
    const fs::path out = named.has_filename() ? named : named.parent_path();  // "a/" is "a"
    args.world.inputs.assign(args.paths.begin(), args.paths.end() - 1);
    const exports::Format& format = exports::find_format_by(args.to, out);
    args.write.up = args.up == "y" ? exports::UpAxis::kY : exports::UpAxis::kZ;
    args.selection.area =
        list_numbers("convert", "--area", args.area, 4,
                     "west,south,east,north, or x0,z0,x1,z1 in a world without a CRS");
    args.write.shard = parse_shard(args.shard);
    if (!args.write.title.empty() && !format.has_title)
        throw util::UsageError("convert: --title " + args.write.title + " to " +
                               std::string(format.name) + "; allowed: to a Minecraft world");
    if (args.write.shard.of > 0 && !format.has_shards)
        throw util::UsageError("convert: --shard " + args.shard + " to " +
                               std::string(format.name) + "; allowed: to a box archive (.tvx)");
    if (args.squares && !format.has_shards)
        throw util::UsageError("convert: --squares " + *args.squares + " to " +
                               std::string(format.name) + "; allowed: to a box archive (.tvx)");
    if (args.squares && names_in(*args.squares).empty())
        throw util::UsageError("convert: --squares '" + *args.squares +
                               "' names none; allowed: names separated by commas");
    if (args.squares && args.write.shard.of > 0)
        throw util::UsageError("convert: --squares with --shard; allowed: one of them");
    args.selection.heights =
        list_numbers("convert", "--heights", args.heights, 2, "lowest,highest in metres");
    format.check_target(out, args.write);
    if (format.has_title)
        args.write.title = make_title(args, out);
    const scene::Scene scene = args.world.scene();
    util::StageTimes times;
    const auto world = worlds::open_world(args.world.options(scene), times);
    const exports::Part part = exports::make_part(world->info(), args.selection);
    const int threads = scene.processing.threads.value_or(0);
    std::uint64_t steps = format.steps(part, world->info());
    if (args.squares) {
        args.write.changed = columns_of_squares(*world, part, names_in(*args.squares), threads);
        steps = args.write.changed.replaced.size() + args.write.changed.compared.size();
    }
    const voxel::Palette palette = voxel::load_palette(material::find_materials(""));
    exports::Meter meter("convert", steps, args.quiet);
    exports::Job job(*world, part, out, palette, meter);
    job.name =
        job_name(args.world, scene, part, *world, std::string(format.name) + " " + args.colours);
    job.colours =
        args.colours == "material" ? exports::Colours::kMaterial : exports::Colours::kTrue;
    job.threads = threads;
    job.memory_bytes = static_cast<std::size_t>(args.memory_mib) << 20;
    format.write(job, args.write);
    meter.finish();
    return report(job, *world,
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
                  args.quiet);
}

}  // namespace

std::function<util::ExitCode()> add_convert_options(CLI::App& app) {
    auto args = std::make_shared<ConvertArguments>();
    app.add_option("paths", args->paths,
                   "what to convert: " + worlds::allowed_inputs() + "; then what to write")
        ->required();
    app.add_option("--to", args->to,
                   "format: " + exports::allowed_formats() + "; default: by the output's ending");
    app.add_option("--level", args->selection.level,
                   "level of the world: voxels of 2^level times its finest")
        ->check(CLI::Range(0, 20));
    app.add_option(
        "--area", args->area,
        "west,south,east,north in the world's CRS; x0,z0,x1,z1 in voxels where it has none");
    app.add_option("--shard", args->shard,
                   "I/N: of a box archive only the I-th of N shards, which other calls may make "
                   "elsewhere at the same time; terravox archive merge joins them");
    app.add_option("--squares", args->squares,
                   "NAME,NAME...: of a box archive only what changes with these squares of LiDAR "
                   "data; terravox archive patch puts it into the archive of all");
    app.add_option("--heights", args->heights, "lowest,highest in metres");
    app.add_option("--colours", args->colours,
                   "of voxels: true (their own, where they have one) or material")
        ->check(CLI::IsMember({"true", "material"}))
        ->capture_default_str();
    app.add_option("--write-memory-mib", args->memory_mib,
                   "memory for writing, in addition to the world's own limit, MiB")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    app.add_option("--title", args->write.title,
                   "of a Minecraft world, in the game's list; default: that of the input, or the "
                   "name of the folder where the input has none");
    app.add_option("--up", args->up, "of .vdb: z (Blender) or y (Houdini)")
        ->check(CLI::IsMember({"z", "y"}))
        ->capture_default_str();
    app.add_option("--colour-steps", args->write.colour_steps,
                   "of .glb and .ply: steps of each colour channel, fewer for larger faces; 0: "
                   "colours as they are")
        ->check(CLI::Range(0, 255))
        ->capture_default_str();
    app.add_flag_callback(
        "--no-merge", [args] { args->write.merge_faces = false; },
        "of .glb and .ply: a face for each side of a voxel");
    app.add_flag("--overwrite", args->write.overwrite, "write over what is there");
    app.add_flag("-q,--quiet", args->quiet, "print errors only");
    add_opening_arguments(app, args->world, {"world", "generated", "processing"});
    return [args] { return run_convert(*args); };
}

}  // namespace terravox::commands
