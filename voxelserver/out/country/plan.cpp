#include "voxelserver/out/country/plan.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::country {

std::string Plan::id() const {
    voxel::ByteWriter out;
    out.add(kPlanVersion);
    out.add(std::string_view(program));
    out.add(box_recipe);
    out.add(voxel::archive::kVersion);
    out.add(std::string_view(fingerprint));
    for (std::size_t a = 0; a < 3; ++a) {
        out.add(bounds.min[a]);
        out.add(bounds.max[a]);
    }
    out.add(std::string_view(world.title));
    out.add(shards.size());
    return voxel::to_hex(out.fingerprint());
}

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kMaxVoxel_m = 1000;
constexpr std::size_t kMaxMemory_bytes = std::size_t{1} << 40;
constexpr std::uintmax_t kMaxPlan_bytes = std::uintmax_t{1} << 30;

/// Paths as they stand in the file.
class Paths {
public:
    explicit Paths(const PlanFolder& folder) : m_folder(folder.path()) {}

    [[nodiscard]] std::string written(const fs::path& path) const {
        if (path.empty() || path.is_absolute())
            return path.string();
        const fs::path whole = fs::current_path() / path;
        std::error_code failed;
        fs::path parent = fs::weakly_canonical(whole.parent_path(), failed);
        if (failed)
            parent = whole.parent_path().lexically_normal();
        return (parent.lexically_relative(m_folder) / path.filename()).string();
    }
    [[nodiscard]] fs::path read(const std::string& text) const {
        const fs::path path = text;
        if (text.empty() || path.is_absolute())
            return path;
        return (m_folder / path).parent_path().lexically_normal() / path.filename();
    }

private:
    fs::path m_folder;
};

bool names_file(const std::string& classes) {
    return fs::path(classes).extension() == ".toml";
}

Json to_json(const Measured& measured) {
    return {{"value", measured.value}, {"error", measured.error}};
}
Measured parse_measured(const Json& json) {
    return {json.at("value").get<double>(), json.at("error").get<double>()};
}

Json to_json(const std::vector<PlannedFile>& files, const Paths& paths) {
    Json out = Json::array();
    for (const PlannedFile& f : files)
        out.push_back({{"file", paths.written(f.file)},
                       {"bytes", f.bytes},
                       {"points", f.points},
                       {"identity", f.identity}});
    return out;
}
std::vector<PlannedFile> list_files(const Json& json, const Paths& paths) {
    std::vector<PlannedFile> out;
    for (const Json& f : json)
        out.push_back({paths.read(f.at("file").get<std::string>()),
                       f.at("bytes").get<std::uint64_t>(), f.at("points").get<std::uint64_t>(),
                       f.at("identity").get<std::string>()});
    return out;
}

Json to_json(const worlds::WorldOptions& world, const Paths& paths) {
    Json inputs = Json::array();
    for (const std::string& input : world.inputs)
        inputs.push_back(paths.written(input));
    Json orthophotos = Json::array();
    for (const fs::path& path : world.orthophotos)
        orthophotos.push_back(paths.written(path));
    Json left_out = Json::array();
    for (const fs::path& path : world.left_out)
        left_out.push_back(paths.written(path));
    return {{"inputs", inputs},
            {"orthophotos", orthophotos},
            {"left_out", left_out},
            {"title", world.title},
            {"crs", world.crs},
            {"classes", names_file(world.classes) ? paths.written(world.classes) : world.classes},
            {"mark_unknown", world.mark_unknown},
            {"vertical_unit", world.vertical_unit},
            {"settings", paths.written(world.settings)},
            {"steps", world.steps},
            {"photo", world.photo},
            {"voxel_m", world.voxel_m},
            {"memory_mib", world.memory_bytes >> 20}};
}
worlds::WorldOptions parse_world(const Json& json, const Paths& paths) {
    worlds::WorldOptions out;
    for (const Json& input : json.at("inputs"))
        out.inputs.push_back(paths.read(input.get<std::string>()).string());
    for (const Json& path : json.at("orthophotos"))
        out.orthophotos.push_back(paths.read(path.get<std::string>()));
    for (const Json& path : json.at("left_out"))
        out.left_out.push_back(paths.read(path.get<std::string>()));
    if (json.contains("title"))  // plans of before the field
        json.at("title").get_to(out.title);
    json.at("crs").get_to(out.crs);
    json.at("classes").get_to(out.classes);
    if (names_file(out.classes))
        out.classes = paths.read(out.classes).string();
    out.mark_unknown = json.value("mark_unknown", false);  // plans of before the option
    json.at("vertical_unit").get_to(out.vertical_unit);
    out.settings = paths.read(json.at("settings").get<std::string>());
    json.at("steps").get_to(out.steps);
    if (json.contains("photo"))  // plans of before the option
        json.at("photo").get_to(out.photo);
    json.at("voxel_m").get_to(out.voxel_m);
    // A number that does not fit is refused with the limit (wrong_in()).
    out.memory_bytes = std::min(json.at("memory_mib").get<std::size_t>(), kMaxMemory_bytes) << 20;
    return out;
}

Plan parse_plan(const Json& json, const Paths& paths) {
    Plan out;
    json.at("program").get_to(out.program);
    json.at("box_recipe").get_to(out.box_recipe);
    out.world = parse_world(json.at("world"), paths);
    json.at("area").get_to(out.area);
    // Plans of before the option have none.
    if (json.contains("heights"))
        json.at("heights").get_to(out.heights);
    json.at("fingerprint").get_to(out.fingerprint);
    json.at("fingerprint_of_all_boxes").get_to(out.fingerprint_of_all_boxes);
    out.known_squares = json.value("known_squares", "");
    json.at("crs").get_to(out.crs);
    json.at("voxel_m").get_to(out.voxel_m);
    json.at("bounds").at("min").get_to(out.bounds.min);
    json.at("bounds").at("max").get_to(out.bounds.max);
    out.squares = list_files(json.at("squares"), paths);
    out.images = list_files(json.at("images"), paths);
    for (const Json& m : json.at("missing"))
        out.missing.push_back({m.at("name").get<std::string>(), m.at("reason").get<std::string>()});
    json.at("scratch_bytes").get_to(out.scratch_bytes);
    for (const Json& s : json.at("shards"))
        out.shards.push_back({s.at("columns").get<std::uint64_t>(),
                              s.at("subtrees").get<std::uint64_t>(),
                              s.at("squares").get<std::uint64_t>(), s.at("cpu_s").get<double>(),
                              s.at("scratch_bytes").get<std::uint64_t>()});
    const Json& estimate = json.at("estimate");
    estimate.at("sampled_columns").get_to(out.estimate.sampled_columns);
    out.estimate.cpu_s = parse_measured(estimate.at("cpu_s"));
    out.estimate.one_machine_cpu_s = parse_measured(estimate.at("one_machine_cpu_s"));
    estimate.at("memory_mib").get_to(out.estimate.memory_mib);
    out.estimate.output_bytes = parse_measured(estimate.at("output_bytes"));
    return out;
}

/// @return what no plan has; empty: nothing
std::string wrong_in(const Plan& plan) {
    if (plan.shards.empty() || plan.shards.size() > static_cast<std::size_t>(kMaxShards))
        return "shards = " + std::to_string(plan.shards.size()) + "; allowed: 1 to " +
               std::to_string(kMaxShards);
    if (plan.world.inputs.empty())
        return "it names no input";
    if (plan.bounds.empty())
        return "its bounds are empty";
    constexpr std::int32_t kFarthest = 1 << 30;
    for (std::size_t a = 0; a < 3; ++a)
        if (plan.bounds.min[a] < -kFarthest || plan.bounds.max[a] > kFarthest)
            return "its bounds lie beyond 2^30 voxels";
    for (const double voxel_m : {plan.voxel_m, plan.world.voxel_m})
        if (!(voxel_m > 0 && voxel_m <= kMaxVoxel_m))
            return "voxel_m = " + std::to_string(voxel_m) + "; allowed: above 0, up to 1000";
    if (plan.world.memory_bytes == 0 || plan.world.memory_bytes > kMaxMemory_bytes)
        return "memory_mib = " + std::to_string(plan.world.memory_bytes >> 20) +
               "; allowed: 1 to 1048576";
    if (!plan.area.empty() && plan.area.size() != 4)
        return "its area has " + std::to_string(plan.area.size()) + " numbers; allowed: 4";
    if (!plan.heights.empty() && plan.heights.size() != 2)
        return "its heights are " + std::to_string(plan.heights.size()) + " numbers; allowed: 2";
    return "";
}

}  // namespace

void write_plan(const PlanFolder& folder, const Plan& plan) {
    const Paths paths(folder);
    Json out{{"format", kPlanVersion},
             {"program", plan.program},
             {"box_recipe", plan.box_recipe},
             {"id", plan.id()},
             {"fingerprint", plan.fingerprint},
             {"fingerprint_of_all_boxes", plan.fingerprint_of_all_boxes},
             {"known_squares", plan.known_squares},
             {"world", to_json(plan.world, paths)},
             {"area", plan.area},
             {"heights", plan.heights},
             {"crs", plan.crs},
             {"voxel_m", plan.voxel_m},
             {"bounds", {{"min", plan.bounds.min}, {"max", plan.bounds.max}}},
             {"missing", Json::array()},
             {"estimate",
              {{"sampled_columns", plan.estimate.sampled_columns},
               {"cpu_s", to_json(plan.estimate.cpu_s)},
               {"one_machine_cpu_s", to_json(plan.estimate.one_machine_cpu_s)},
               {"memory_mib", plan.estimate.memory_mib},
               {"output_bytes", to_json(plan.estimate.output_bytes)}}},
             {"scratch_bytes", plan.scratch_bytes}};
    for (const MissingSquare& m : plan.missing)
        out["missing"].push_back({{"name", m.name}, {"reason", m.reason}});
    out["shards"] = Json::array();
    for (const PlannedShard& s : plan.shards)
        out["shards"].push_back({{"columns", s.columns},
                                 {"subtrees", s.subtrees},
                                 {"squares", s.squares},
                                 {"cpu_s", s.cpu_s},
                                 {"scratch_bytes", s.scratch_bytes}});
    out["squares"] = to_json(plan.squares, paths);
    out["images"] = to_json(plan.images, paths);
    try {
        util::write_file_atomically(folder.plan(), out.dump(1) + "\n", util::Links::kReplace);
    } catch (const Json::type_error&) {
        throw util::UsageError("write the plan " + folder.plan().string() +
                               ": the path of an input is no UTF-8; allowed: UTF-8, which JSON is "
                               "written in");
    }
}

Plan read_plan(const PlanFolder& folder) {
    const fs::path file = folder.plan();
    const auto damaged = [&](const std::string& what) {
        return util::Error("read the plan " + file.string() + ": " + what);
    };
    std::error_code failed;
    const auto size = fs::file_size(file, failed);
    if (failed)
        throw util::UsageError("read the plan " + folder.path().string() +
                               ": it holds no plan.json; allowed: a folder that terravox country "
                               "plan has written");
    if (size > kMaxPlan_bytes)
        throw damaged("it has " + std::to_string(size) + " bytes; allowed: up to 1 GiB");
    std::ifstream in(file, std::ios::binary);
    Json json = Json::parse(in, nullptr, false);
    if (json.is_discarded() || !json.is_object())
        throw damaged("it is no JSON object");
    try {
        if (const Json& format = json.at("format"); format != kPlanVersion)
            throw damaged("format " + (format.is_number() ? format.dump() : "unknown") +
                          "; allowed: " + std::to_string(kPlanVersion) +
                          "; plan again with this program");
        Plan plan = parse_plan(json, Paths(folder));
        if (const std::string wrong = wrong_in(plan); !wrong.empty())
            throw damaged(wrong);
        return plan;
    } catch (const Json::exception& e) {
        throw damaged(std::string("it is damaged: ") + e.what());
    }
}

PlanFolder::PlanFolder(const fs::path& folder) {
    std::error_code failed;
    m_path = fs::canonical(folder, failed);
    if (failed || !fs::is_directory(m_path, failed))
        throw util::UsageError("open the plan " + folder.string() +
                               ": there is no such folder; allowed: one that terravox country "
                               "plan has written");
    // A plan may be a stranger's.
    if (fs::is_symlink(scratch(), failed))
        throw util::UsageError("open the plan " + folder.string() + ": " + scratch().string() +
                               " is a symbolic link, and folders behind it would be removed; "
                               "allowed: a folder, or none");
}

fs::path PlanFolder::shard(int number) const {
    std::array<char, 16> name{};
    std::snprintf(name.data(), name.size(), "%05d.tvx", number);
    return m_path / "shards" / name.data();
}

fs::path PlanFolder::of_task(int number, const char* ending) const {
    std::array<char, 24> name{};
    std::snprintf(name.data(), name.size(), "%05d.%s", number, ending);
    return m_path / "tasks" / name.data();
}

fs::path PlanFolder::lock(int number) const {
    return of_task(number, "lock");
}

fs::path PlanFolder::record(int number) const {
    return of_task(number, "json");
}

fs::path PlanFolder::log(int number) const {
    return of_task(number, "txt");
}

void PlanFolder::make_folders() const {
    for (const char* name : {"shards", "tasks"}) {
        std::error_code failed;
        fs::create_directories(m_path / name, failed);
        if (failed)
            throw util::Error("make the folder " + (m_path / name).string() + ": " +
                              failed.message());
    }
}

std::string fingerprint_of_known(std::string_view bytes) {
    voxel::ByteWriter out;
    out.add(std::string(bytes));
    return voxel::to_hex(out.fingerprint());
}

bool has_known_squares(const PlanFolder& folder, const Plan& plan) {
    std::ifstream in(folder.known_squares(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return in && fingerprint_of_known(bytes) == plan.known_squares;
}

}  // namespace terravox::country
