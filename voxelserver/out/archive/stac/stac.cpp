#include "voxelserver/out/archive/stac/stac.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::stac {
namespace {

bool has_form(std::string_view text, std::string_view form) {
    return std::equal(text.begin(), text.end(), form.begin(), form.end(),
                      [](char c, char f) { return f == '0' ? c >= '0' && c <= '9' : c == f; });
}

/// @return a number of digits
unsigned number_at(std::string_view text, std::size_t begin, std::size_t digits) {
    unsigned out = 0;
    for (const char c : text.substr(begin, digits))
        out = out * 10 + static_cast<unsigned>(c - '0');
    return out;
}

/// The first and the last second of a date, or twice an instant.
std::optional<StacTime> parse_stac_time(std::string_view text) {
    constexpr std::string_view kDate = "0000-00-00";
    const bool is_date = has_form(text, kDate);
    if (!is_date && !has_form(text, "0000-00-00T00:00:00Z"))
        return std::nullopt;
    const std::chrono::year_month_day day{
        std::chrono::year(static_cast<int>(number_at(text, 0, 4))),
        std::chrono::month(number_at(text, 5, 2)), std::chrono::day(number_at(text, 8, 2))};
    if (!day.ok())
        return std::nullopt;
    const std::string whole(text);
    if (is_date)
        return StacTime{whole + "T00:00:00Z", whole + "T23:59:59Z"};
    if (number_at(text, 11, 2) > 23 || number_at(text, 14, 2) > 59 || number_at(text, 17, 2) > 59)
        return std::nullopt;
    return StacTime{whole, whole};
}

}  // namespace

StacTime stac_time(const std::string& text) {
    const std::size_t slash = std::min(text.find('/'), text.size());
    const auto first = parse_stac_time(std::string_view(text).substr(0, slash));
    const auto last =
        slash == text.size() ? first : parse_stac_time(std::string_view(text).substr(slash + 1));
    // Texts of one form sort by time.
    if (!first || !last || last->end < first->start)
        throw util::UsageError("stac: --datetime " + text +
                               "; allowed: 2023-04-01, 2023-04-01T10:30:00Z, or two of these with "
                               "a slash, the earlier first");
    return {first->start, last->end};
}

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// @throws UsageError unless it is an address with a scheme and a host, or empty
void check_href(const std::string& href) {
    const std::size_t scheme = href.find("://");
    const bool is_plain = std::all_of(href.begin(), href.end(), [](char c) {
        return c > ' ' && c <= '~' &&
               std::string_view("?#@\\\"<>").find(c) == std::string_view::npos;
    });
    if (!href.empty() && (scheme == 0 || scheme == std::string::npos || scheme + 3 == href.size() ||
                          href[scheme + 3] == '/' || !is_plain))
        throw util::UsageError("stac: --href " + href +
                               "; allowed: the address of a folder without a user, ? or #, "
                               "https://example.org/data");
}

/// Where an archive lies, seen from its item.
std::string make_href(const fs::path& archive, const StacRequest& request) {
    const std::string name = archive.filename().string();
    if (!request.href.empty())
        return request.href + (request.href.ends_with('/') ? "" : "/") + url_segment(name);
    // A path that leads out of the folder would say how this machine's disks are arranged.
    const fs::path folder = fs::weakly_canonical(fs::absolute(request.folder));
    const fs::path inside = (fs::weakly_canonical(fs::absolute(archive).parent_path()) / name)
                                .lexically_relative(folder);
    if (inside.empty() || *inside.begin() == "..")
        throw util::UsageError("stac of " + archive.string() + ": it lies outside of " +
                               request.folder.string() +
                               "; allowed: -o its folder or one above it, or --href URL");
    std::string out = ".";
    for (const fs::path& step : inside)
        out += "/" + url_segment(step.string());
    return out;
}

std::string collection_id(const StacRequest& request) {
    if (!request.collection.empty() || request.archives.size() == 1)
        return request.collection;
    const fs::path folder = fs::weakly_canonical(fs::absolute(request.folder));
    const std::string name =
        (folder.has_filename() ? folder : folder.parent_path()).filename().string();
    return name.empty() ? "archives" : name;
}

/// Of licences that differ there is no common one.
std::string find_licence(const std::vector<StacItem>& items) {
    const bool is_one = std::all_of(items.begin(), items.end(), [&](const StacItem& item) {
        return item.licence == items.front().licence;
    });
    return is_one ? items.front().licence : "various";
}

Json make_collection(const std::string& id, const std::vector<StacItem>& items,
                     const StacTime& time) {
    std::array<double, 4> bbox = items.front().bbox_deg;
    Json links =
        Json::array({stac_link("root", std::string("./") + kStacCollection, "application/json")});
    std::set<double> voxels_m;
    for (const StacItem& item : items) {
        for (const std::size_t low : {0, 1}) {
            bbox[low] = std::min(bbox[low], item.bbox_deg[low]);
            bbox[low + 2] = std::max(bbox[low + 2], item.bbox_deg[low + 2]);
        }
        voxels_m.insert(item.json["properties"]["terravox:voxel_m"].get<double>());
        links.push_back(
            stac_link("item", "./" + url_segment(item.id + ".json"), "application/geo+json"));
    }
    Json out;
    out["type"] = "Collection";
    out["stac_version"] = kStacVersion;
    out["stac_extensions"] = Json::array();
    out["id"] = id;
    out["description"] =
        "Places as voxels, in box archives of Terravox: " + std::to_string(items.size()) +
        " of them.";
    out["license"] = find_licence(items);
    out["extent"]["spatial"]["bbox"] = Json::array({bbox});
    out["extent"]["temporal"]["interval"] = Json::array({Json::array({time.start, time.end})});
    out["summaries"]["terravox:voxel_m"] = voxels_m;
    out["links"] = std::move(links);
    return out;
}

/// Names of archives are names of files of the folder, which must differ.
void check_names(const std::vector<StacItem>& items, bool has_collection) {
    std::set<std::string> names;
    if (has_collection)
        names.insert(kStacCollection);
    for (const StacItem& item : items)
        if (!names.insert(item.id + ".json").second)
            throw util::UsageError("stac: two files would have the name " + item.id +
                                   ".json; allowed: archives with names of their own, other than "
                                   "that of the collection");
}

}  // namespace

StacReport write_stac(const StacRequest& request) {
    check_href(request.href);
    const std::string collection = collection_id(request);
    StacReport out;
    std::vector<StacItem> items;
    for (const fs::path& archive : request.archives) {
        items.push_back(stac_item(archive, request.time, make_href(archive, request), collection));
        out.holes += items.back().holes;
    }
    check_names(items, !collection.empty());
    std::vector<std::pair<fs::path, Json>> texts;
    for (StacItem& item : items)
        texts.emplace_back(request.folder / (item.id + ".json"), item.json);
    if (!collection.empty())
        texts.emplace_back(request.folder / kStacCollection,
                           make_collection(collection, items, request.time));
    for (const auto& [file, json] : texts) {
        std::error_code ignored;
        if (!request.overwrite && fs::exists(file, ignored))
            throw util::UsageError(
                "stac: write " + file.string() +
                ": it is there already; allowed: another folder, or --overwrite");
    }
    for (const auto& [file, json] : texts) {
        util::write_file_atomically(file,
                                    json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n",
                                    util::Links::kReplace);
        out.files.push_back(file);
    }
    return out;
}

}  // namespace terravox::stac
