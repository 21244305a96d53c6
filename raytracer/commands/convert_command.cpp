#include "raytracer/commands/convert_command.hpp"

#include <spdlog/spdlog.h>
#include <xxhash.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <regex>
#include <sstream>

#include "common/util/atomic_file.hpp"
#include "common/util/config_dir.hpp"
#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "common/voxel/log_damage.hpp"
#include "common/voxel/world_json.hpp"
#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/material/material_file.hpp"
#include "raytracer/scene/scene_io.hpp"
#include "voxelserver/export/anvil/write_anvil.hpp"
#include "voxelserver/export/archive/archive_export.hpp"
#include "voxelserver/export/core/format.hpp"
#include "voxelserver/export/core/part.hpp"
#include "voxelserver/export/mesh/mesh.hpp"
#include "voxelserver/export/vdb/vdb.hpp"
#include "voxelserver/export/vox/vox.hpp"
#include "voxelserver/worlds/open/open_world.hpp"
#include "voxelserver/worlds/open/world_kinds.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;
using exports::Format;

struct Arguments {
    WorldArguments world;
    std::vector<std::string> paths;
    std::string to, colours = "true", up = "z";
    exports::MeshOptions mesh;
    std::string area, heights;
    exports::Selection selection;
    int memory_mib = 1024;
    bool overwrite = false, quiet = false;
};

// @param allowed the expected text, for messages
std::vector<double> numbers_of(const std::string& flag, const std::string& text, std::size_t count,
                               const std::string& allowed) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        double value = 0;
        const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
        if (read.ec != std::errc{} || read.ptr != word.data() + word.size() ||
            !std::isfinite(value))
            break;
        out.push_back(value);
    }
    if (!text.empty() &&
        (out.size() != count ||
         static_cast<std::size_t>(std::count(text.begin(), text.end(), ',')) + 1 != count))
        throw util::UsageError("convert: " + flag + " " + text + "; allowed: " + allowed);
    return out;
}

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

// Two conversions with the same settings that affect their files have the same name: inputs and
// data files with size and time, part, options.
std::string name_of_job(const Arguments& args, scene::Scene scene, const exports::Part& part,
                        const voxel::World& world, Format format) {
    scene.processing = {};
    scene.world.memory_mib = scene::Scene::World{}.memory_mib;
    std::string facts = std::string(kVersion) + '\n' + scene::to_toml(scene) +
                        voxel::world_to_json(world.info()) + world.edition() + args.colours;
    for (const auto* list : {&args.world.inputs, &args.world.orthophotos})
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
    char text[64];
    std::snprintf(text, sizeof text, "terravox %s %016llx",
                  std::string(exports::name_of(format)).c_str(),
                  static_cast<unsigned long long>(
                      XXH64(facts.data(), facts.size(), static_cast<std::uint64_t>(part.level))));
    return text;
}

// Files that an earlier conversion to this .vdb may have left: the file, or the files that a large
// one is divided into.
std::vector<fs::path> vdb_files(const fs::path& out) {
    const std::regex name(R"((.*)_\d+_\d+\.vdb)");
    std::vector<fs::path> files;
    std::error_code failed;
    if (fs::exists(out, failed))
        files.push_back(out);
    const fs::path folder = out.has_parent_path() ? out.parent_path() : fs::path(".");
    for (fs::directory_iterator it(folder, failed), end; !failed && it != end;
         it.increment(failed)) {
        std::smatch match;
        const std::string file = it->path().filename().string();
        if (std::regex_match(file, match, name) && match[1] == out.stem().string())
            files.push_back(it->path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

// A Minecraft world is never overwritten: it may have been edited by players.
void check_target(const Arguments& args, const fs::path& out, Format format) {
    if (format == Format::kAnvil) {
        util::check_writable(out / "level.dat");
        if (args.overwrite)
            throw util::UsageError(
                "convert to " + out.string() +
                ": --overwrite; allowed: with files, not with a Minecraft world's folder");
        return;
    }
    util::check_writable(out);
    if (format == Format::kVdb)
        if (const auto there = vdb_files(out); !there.empty() && !args.overwrite)
            throw util::UsageError("convert to " + out.string() + ": " + there.front().string() +
                                   " is there already; allowed: another name, or --overwrite");
    if (fs::is_directory(out))
        throw util::UsageError("convert to " + out.string() +
                               ": it is a folder; allowed: the name of a file");
    if (fs::exists(out) && !args.overwrite)
        throw util::UsageError("convert to " + out.string() +
                               ": it is there already; allowed: another name, or --overwrite");
}

std::uint64_t steps_of(Format format, const exports::Part& part, const voxel::WorldInfo& world) {
    if (format == Format::kArchive)
        return exports::archive_steps(part, world);
    const voxel::BoxRange boxes = part.boxes();
    return static_cast<std::uint64_t>(boxes.max.bx - boxes.min.bx) *
           static_cast<std::uint64_t>(boxes.max.bz - boxes.min.bz);
}

void write(const Arguments& args, Format format, exports::Job& job) {
    switch (format) {
        case Format::kArchive: return exports::write_archive(job);
        case Format::kAnvil: return exports::anvil::write_anvil(job, {});
        case Format::kVox: return exports::write_vox(job);
        case Format::kVdb:
            return exports::write_vdb(job,
                                      {args.up == "y" ? exports::VdbUp::kY : exports::VdbUp::kZ});
        case Format::kGlb: return exports::write_mesh(job, exports::MeshFormat::kGlb, args.mesh);
        case Format::kPly: return exports::write_mesh(job, exports::MeshFormat::kPly, args.mesh);
    }
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
        spdlog::error("what was written has holes: {} boxes could not be loaded", holes);
    if (!damage.empty())
        voxel::log_damage(damage);
    return holes > 0 || !damage.empty() ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode run(Arguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    if (args.paths.size() < 2)
        throw util::UsageError("convert: " + std::to_string(args.paths.size()) +
                               " path; allowed: what to convert, then what to write");
    const auto start = std::chrono::steady_clock::now();
    const fs::path named = args.paths.back(),
                   out = named.has_filename() ? named : named.parent_path();  // "a/" is "a"
    args.world.inputs.assign(args.paths.begin(), args.paths.end() - 1);
    const Format format = exports::format_of(args.to, out);
    args.selection.area = numbers_of(
        "--area", args.area, 4, "west,south,east,north, or x0,z0,x1,z1 in a world without a CRS");
    args.selection.heights = numbers_of("--heights", args.heights, 2, "lowest,highest in metres");
    check_target(args, out, format);
    const scene::Scene scene = args.world.scene();
    util::StageTimes times;
    const auto world = worlds::open_world(args.world.options(scene), times);
    const exports::Part part = exports::part_of(world->info(), args.selection);
    const voxel::Palette palette = voxel::load_palette(material::find_materials(""));
    exports::Meter meter("convert", steps_of(format, part, world->info()), args.quiet);
    exports::Job job(*world, part, out, palette, meter);
    job.name = name_of_job(args, scene, part, *world, format);
    job.colours =
        args.colours == "material" ? exports::Colours::kMaterial : exports::Colours::kTrue;
    job.threads = scene.processing.threads.value_or(0);
    job.memory_bytes = static_cast<std::size_t>(args.memory_mib) << 20;
    const auto before = format == Format::kVdb ? vdb_files(out) : std::vector<fs::path>{};
    write(args, format, job);
    meter.finish();
    // Files of another division would be mixed with the new ones.
    const auto written = job.files();
    for (const fs::path& file : before)
        if (std::none_of(written.begin(), written.end(),
                         [&](const fs::path& w) { return w.filename() == file.filename(); })) {
            fs::remove(file);
            fs::remove(file.string() + ".georef.json");
        }
    return report(job, *world,
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
                  args.quiet);
}

}  // namespace

std::function<util::ExitCode()> add_convert_command(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand(
        "convert",
        "Convert a world to a box archive, a Minecraft world, or another program's format");
    command
        ->add_option("paths", args->paths,
                     "what to convert: " + worlds::allowed_inputs() + "; then what to write")
        ->required();
    command->add_option("--to", args->to,
                        "format: " + exports::formats() + "; default: by the output's ending");
    command
        ->add_option("--level", args->selection.level,
                     "level of the world: voxels of 2^level times its finest")
        ->check(CLI::Range(0, 20));
    command->add_option(
        "--area", args->area,
        "west,south,east,north in the world's CRS; x0,z0,x1,z1 in voxels where it has none");
    command->add_option("--heights", args->heights, "lowest,highest in metres");
    command
        ->add_option("--colours", args->colours,
                     "of voxels: true (their own, where they have one) or material")
        ->check(CLI::IsMember({"true", "material"}))
        ->capture_default_str();
    command
        ->add_option("--write-memory-mib", args->memory_mib,
                     "what writing may hold, beside the world's own limit, MiB")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    command->add_option("--up", args->up, "of .vdb: z (Blender) or y (Houdini)")
        ->check(CLI::IsMember({"z", "y"}))
        ->capture_default_str();
    command
        ->add_option("--colour-steps", args->mesh.colour_steps,
                     "of .glb and .ply: steps of each colour channel, fewer for larger faces; 0: "
                     "colours as they are")
        ->check(CLI::Range(0, 255))
        ->capture_default_str();
    command->add_flag_callback(
        "--no-merge", [args] { args->mesh.merge = false; },
        "of .glb and .ply: a face for each side of a voxel");
    command->add_flag("--overwrite", args->overwrite, "write over what is there");
    command->add_flag("-q,--quiet", args->quiet, "say nothing but errors");
    add_opening_arguments(*command, args->world, {"world", "generated", "processing"});
    return [args] { return run(*args); };
}

}  // namespace terravox::commands
