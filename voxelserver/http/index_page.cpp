#include "voxelserver/http/index_page.hpp"

#include <array>
#include <cstdio>

#include "common/util/version.hpp"

namespace terravox::http {
namespace {

struct ApiRow {
    const char *path, *what;
};

constexpr std::array kApi = {
    ApiRow{"/v2/world", "the world: bounds, levels, CRS, materials, licence (JSON)"},
    ApiRow{"/v2/boxes/{level}/{bx}/{by}/{bz}", "a box of 64 x 256 x 64 voxels (application/vnd.terravox.box, zstd); 204 for air"},
    ApiRow{"/v2/columns/{level}/{bx}/{bz}", "which boxes of a column may hold anything (JSON)"},
    ApiRow{"/v2/stats", "times of the steps, cache, requests (JSON)"},
    ApiRow{"/healthz", "200 while the server is ready"},
};

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
}

std::string row(std::string_view name, std::string_view value) {
    return "<tr><th>" + escape_html(name) + "</th><td>" + escape_html(value) + "</td></tr>\n";
}

std::string world_rows(const voxel::WorldInfo& info) {
    static constexpr std::array kAxes = {"x (east)", "y (up)", "z (south)"};
    std::string out;
    for (std::size_t a = 0; a < 3; ++a)
        out += row(kAxes[a], std::to_string(info.bounds.min[a]) + " to " + std::to_string(info.bounds.max[a]) + " voxels");
    out += row("voxel", number(info.voxel_m) + " m");
    out += row("levels", "0 to " + std::to_string(info.levels - 1));
    if (!info.crs.empty()) out += row("CRS", info.crs);
    if (info.centre) out += row("centre", number(info.centre->lat_deg) + ", " + number(info.centre->lon_deg));
    if (!info.licence.empty()) out += row("licence", info.licence);
    if (!info.attribution.empty()) out += row("attribution", info.attribution);
    return out;
}

std::string api_rows() {
    std::string out;
    for (const ApiRow& api : kApi) {
        const std::string path = escape_html(api.path);
        const bool link = path.find('{') == std::string::npos;
        out += "<tr><td>" + (link ? "<a href=\"" + path + "\"><code>" + path + "</code></a>" : "<code>" + path + "</code>") + "</td><td>" +
               escape_html(api.what) + "</td></tr>\n";
    }
    return out;
}

}  // namespace

std::string escape_html(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            case '\'': out += "&#39;"; break;
            default: out += c;
        }
    return out;
}

std::string index_page(const voxel::WorldInfo& info) {
    const std::string title = escape_html(info.title.empty() ? "a world" : info.title);
    return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n<title>" + title +
           " - Terravox voxel server</title>\n"
           "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}"
           "table{border-collapse:collapse;width:100%}th,td{text-align:left;vertical-align:top;padding:.3rem .8rem .3rem 0;border-bottom:1px solid #ddd}"
           "@media(prefers-color-scheme:dark){body{color:#ddd;background:#1b1b1b}th,td{border-color:#444}a{color:#8bf}}</style>\n</head><body>\n<h1>" +
           title + "</h1>\n<table>\n" + world_rows(info) + "</table>\n<h2>HTTP interface</h2>\n<table>\n" + api_rows() + "</table>\n<p>terravox " +
           escape_html(kVersion) + "</p>\n</body></html>\n";
}

}  // namespace terravox::http
