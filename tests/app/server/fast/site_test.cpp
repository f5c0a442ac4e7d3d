#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

#include "app/server/session.hpp"
#include "app/server/site.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::server {
namespace {

namespace fs = std::filesystem;

void write(const fs::path &path, const std::string &text = "text") {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

/// A folder with results, and a secret beside it.
class SiteTest : public testing::Test {
  protected:
    SiteTest() {
        write(results / "liver" / "pull.h5");
        write(results / "a b%\".h5");
        write(results / "notes.txt");
        write(top / "secret.h5");
        write(top / "results_of_others" / "theirs.h5");
    }
    ~SiteTest() override { fs::remove_all(top); }

    int status(const std::string &target, const std::string &method = "GET") const {
        return respond(request(target, method), site).status;
    }
    int status_of(const std::string &host, const std::optional<std::string> &origin, std::uint16_t port = 8421) const {
        auto site_at_port = site;
        site_at_port.port = port;
        auto asked = request("/?token=secret");
        asked.host = host;
        asked.origin = origin;
        return respond(asked, site_at_port).status;
    }
    static Request request(const std::string &target, const std::string &method = "GET") {
        return {.method = method,
                .target = target,
                .host = "localhost:8421",
                .origin = {},
                .cookies = "other=1; livermark_8421=secret"};
    }

    const fs::path top = fs::temp_directory_path() / ("livermark_site_" + std::to_string(getpid()));
    const fs::path results = top / "results";
    const Site site{.folder = results,
                    .page = "/somewhere/index.html",
                    .port = 8421,
                    .token = "secret",
                    .is_result_file = [](const fs::path &) { return true; }};
};

TEST_F(SiteTest, ServesThePageAndTheFilesOfTheFolder) {
    EXPECT_EQ(respond(request("/files/liver/pull.h5"), site).file, results / "liver" / "pull.h5");
    EXPECT_EQ(status("/"), 200);
    EXPECT_EQ(status("/?anything"), 200);
    EXPECT_EQ(status("/", "HEAD"), 200);
    EXPECT_EQ(status("/files/a%20b%25%22.h5"), 200);
}

TEST_F(SiteTest, ServesTheImageOfAResultFileOrSaysWhyNot) {
    auto with_images = site;
    with_images.image_of = [&](const fs::path &file) {
        if (file != results / "liver" / "pull.h5")
            throw support::InputError("this body was not made of an image");
        return std::string("{}");
    };
    const auto image = respond(request("/image/liver/pull.h5"), with_images);
    EXPECT_EQ(image.status, 200);
    EXPECT_EQ(image.content_type, "application/json");
    EXPECT_EQ(image.text, "{}");
    const auto none = respond(request("/image/a%20b%25%22.h5"), with_images);
    EXPECT_EQ(none.status, 404);
    EXPECT_EQ(none.text, "this body was not made of an image\n");
    EXPECT_EQ(respond(request("/image/../secret.h5"), with_images).status, 404);
    EXPECT_EQ(respond(request("/image/notes.txt"), with_images).status, 404);
    auto stranger = request("/image/liver/pull.h5");
    stranger.cookies.clear();
    EXPECT_EQ(respond(stranger, with_images).status, 403);
}

TEST_F(SiteTest, ListsResultFilesByNameAsJson) {
    EXPECT_EQ(respond(request("/files.json"), site).text,
              R"([{"path":"a b%\".h5","bytes":4},{"path":"liver/pull.h5","bytes":4}])");
    auto choosy = site;
    choosy.is_result_file = results::is_shown_on_page;
    EXPECT_EQ(respond(request("/files.json"), choosy).text, "[]");
}

TEST_F(SiteTest, SendsResultFilesOnly) {
    auto choosy = site;
    choosy.is_result_file = results::is_shown_on_page;
    EXPECT_EQ(respond(request("/files/liver/pull.h5"), choosy).status, 404);
    results::write_result(results / "real.h5", tests::sample_result(2));
    EXPECT_EQ(respond(request("/files/real.h5"), choosy).status, 200);
}

TEST_F(SiteTest, LeavesOutNamesThatAreNotUtf8) {
    const auto before = result_files(site).paths;
    const std::vector<std::string> names{"\xff",     "caf\xe9", "\xc0\xaf",    "\xed\xa0\x80", "\xf4\x90\x80\x80",
                                         "\xe2\x82", "\x80",    "\xe0\x80\xaf"};
    for (const auto &name : names)
        write(results / (name + ".h5"));
    EXPECT_EQ(result_files(site).num_not_utf8, static_cast<int>(names.size()));
    EXPECT_EQ(result_files(site).paths, before);
    write(results / "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80.h5");
    EXPECT_EQ(result_files(site).paths.size(), before.size() + 1);
}

TEST_F(SiteTest, LetsInWhoHasTheTokenOnly) {
    for (const auto *target : {"/", "/files.json", "/files/liver/pull.h5"}) {
        auto stranger = request(target);
        for (const auto *cookies :
             {"", "livermark_8421=", "livermark_8421=secre", "livermark_8421=secrets", "livermark_8422=secret",
              "xlivermark_8421=secret", "livermark_8421 =secret", "secret"}) {
            stranger.cookies = cookies;
            EXPECT_EQ(respond(stranger, site).status, 403) << target << ' ' << cookies;
        }
        EXPECT_NE(respond(stranger, site).text.find("open the address that `livermark view` printed"),
                  std::string::npos);
        for (const auto *query :
             {"?token=", "?token=Secret", "?token", "?x=secret", "?token=secret&token=secret", "?%"}) {
            stranger.target = std::string(target) + query;
            EXPECT_EQ(respond(stranger, site).status, 403) << stranger.target;
        }
        stranger.target = std::string(target) + "?token=secret";
        EXPECT_EQ(respond(stranger, site).status, 200) << target;
    }
    auto two = request("/");
    two.cookies = "livermark_8421=of another server;livermark_8421=secret";
    EXPECT_EQ(respond(two, site).status, 200);
    auto open_to_all = site;
    open_to_all.token = "";
    auto nobody = request("/?token=");
    nobody.cookies = "livermark_8421=";
    EXPECT_EQ(respond(nobody, open_to_all).status, 403);
}

TEST_F(SiteTest, GivesACookieToAVisitWithTheToken) {
    EXPECT_EQ(respond(request("/?token=secret"), site).set_cookie,
              "livermark_8421=secret; Path=/; HttpOnly; SameSite=Strict");
    EXPECT_EQ(respond(request("/"), site).set_cookie, "");
    EXPECT_EQ(respond(request("/?token=other"), site).set_cookie, "");
}

TEST_F(SiteTest, MakesTokensThatDiffer) {
    const auto token = new_token();
    EXPECT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(token, new_token());
}

TEST_F(SiteTest, AnswersNoRequestThatTheBrowserTakesFromAnotherSite) {
    for (const auto *from : {"cross-site", "same-site", "", "anything"})
        for (const auto *target : {"/", "/files.json", "/files/liver/pull.h5", "/files.json?token=secret"}) {
            auto ghost = request(target);
            ghost.fetch_site = from;
            EXPECT_EQ(respond(ghost, site).status, 403) << from << ' ' << target;
        }
    for (const auto *from : {"same-origin", "none"}) {
        auto own = request("/files.json");
        own.fetch_site = from;
        EXPECT_EQ(respond(own, site).status, 200) << from;
    }
    auto link = request("/?token=secret");
    link.fetch_site = "cross-site";
    EXPECT_EQ(respond(link, site).status, 200);
}

TEST_F(SiteTest, AsksOnceAboutAFileThatStaysAsItIs) {
    auto num_asked = std::make_shared<int>(0);
    auto remembering = site;
    remembering.is_result_file = remembered([num_asked](const fs::path &) {
        ++*num_asked;
        return true;
    });
    for (int i = 0; i < 100; ++i)
        EXPECT_EQ(respond(request("/files.json"), remembering).status, 200);
    EXPECT_EQ(*num_asked, 2);
    write(results / "liver" / "pull.h5", "longer than before");
    EXPECT_EQ(result_files(remembering).paths.size(), 2U);
    EXPECT_EQ(*num_asked, 3);
    fs::remove(results / "liver" / "pull.h5");
    EXPECT_EQ(respond(request("/files/liver/pull.h5"), remembering).status, 404);
}

/// Nobody can say whether a file that another program writes is a result file: it is asked about again.
TEST_F(SiteTest, LeavesOutAFileThatIsInUseAndLooksAgain) {
    auto remembering = site;
    const auto is_in_use = std::make_shared<bool>(true);
    remembering.is_result_file = remembered([is_in_use](const fs::path &path) {
        if (*is_in_use && path.filename() == "pull.h5")
            throw results::FileInUse("pull.h5: another program has the file open to write");
        return true;
    });
    EXPECT_EQ(result_files(remembering).paths.size(), 1U);
    EXPECT_EQ(result_files(remembering).num_in_use, 1);
    EXPECT_THROW(respond(request("/files/liver/pull.h5"), remembering), support::InputError);
    *is_in_use = false;
    EXPECT_EQ(result_files(remembering).paths.size(), 2U);
    EXPECT_EQ(result_files(remembering).num_in_use, 0);
    EXPECT_EQ(respond(request("/files/liver/pull.h5"), remembering).status, 200);
}

TEST_F(SiteTest, NeverLeavesTheFolder) {
    for (const auto *target :
         {"/files/../secret.h5", "/files/%2e%2e/secret.h5", "/files/..%2fsecret.h5", "/files/liver/../../secret.h5",
          "/files/../results_of_others/theirs.h5", "/files//etc/passwd", "/files/%2fetc%2fpasswd", "/../secret.h5",
          "/files/liver/../liver/pull.h5", "/files/./liver/pull.h5", "/files/secret.h5%00.h5", "/files/",
          "/files/liver", "/files/notes.txt", "/secret.h5", "/files", ""})
        EXPECT_EQ(status(target), 404) << target;
    EXPECT_EQ(status("/files/" + (top / "secret.h5").string()), 404);
    EXPECT_EQ(status("http://127.0.0.1:8421/"), 404);
}

TEST_F(SiteTest, FollowsLinksWithinTheFolderOnly) {
    fs::create_symlink(top / "secret.h5", results / "out.h5");
    fs::create_directory_symlink(top / "results_of_others", results / "others");
    fs::create_symlink(results / "notes.txt", results / "disguised.h5");
    fs::create_symlink(results / "liver" / "pull.h5", results / "again.h5");
    EXPECT_EQ(status("/files/out.h5"), 404);
    EXPECT_EQ(status("/files/others/theirs.h5"), 404);
    EXPECT_EQ(status("/files/disguised.h5"), 404);
    EXPECT_EQ(status("/files/again.h5"), 200);
    EXPECT_EQ(result_files(site).paths, (std::vector<std::string>{"a b%\".h5", "again.h5", "liver/pull.h5"}));
}

TEST_F(SiteTest, AnswersItsOwnPagesOnly) {
    EXPECT_EQ(status_of("127.0.0.1:8421", std::nullopt), 200);
    EXPECT_EQ(status_of("localhost:8421", "http://localhost:8421"), 200);
    EXPECT_EQ(status_of("localhost:8421", "http://127.0.0.1:8421"), 200);
    for (const auto *host : {"", "localhost", "localhost:84210", "localhost:842", "evil:8421", "localhost.evil:8421",
                             "127.0.0.1:8421, 127.0.0.1:8421", "127.0.0.1:8421 ", "LOCALHOST:8421", "0.0.0.0:8421"})
        EXPECT_EQ(status_of(host, std::nullopt), 403) << host;
    for (const auto *origin : {"", "null", "http://localhost", "https://localhost:8421", "http://localhost.evil:8421",
                               "http://localhost:8421.evil", "http://localhost:84211", "localhost:8421",
                               "http://evil/http://localhost:8421", "file://"})
        EXPECT_EQ(status_of("127.0.0.1:8421", origin), 403) << origin;
}

TEST_F(SiteTest, IsAskedAtPortEightyWithoutIt) {
    EXPECT_EQ(status_of("127.0.0.1", "http://localhost", 80), 200);
    EXPECT_EQ(status_of("localhost:80", std::nullopt, 80), 200);
    EXPECT_EQ(status_of("localhost:8421", std::nullopt, 80), 403);
    EXPECT_EQ(status_of("localhost", "http://localhost:8421", 80), 403);
}

TEST_F(SiteTest, OnlyShows) {
    for (const auto *method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", ""})
        EXPECT_EQ(status("/", method), 405) << method;
}

TEST_F(SiteTest, RefusesAnAddressThatIsNotWellFormed) {
    for (const auto *target : {"/files/%", "/files/%2", "/files/%zz.h5", "/%+1"})
        EXPECT_EQ(status(target), 400) << target;
}

TEST(Fields, AreReadAsABrowserWritesThem) {
    EXPECT_EQ(parse_fields(""), Fields{});
    EXPECT_EQ(parse_fields("file=a%20b%2Fc+d%25.h5&e=&f&&g=1=2"),
              (Fields{{"file", "a b/c d%.h5"}, {"e", ""}, {"f", ""}, {"g", "1=2"}}));
}

TEST(Fields, ComeBackFromTheirText) {
    const Fields fields{{"fault", "a & b = \"50 %\" + µ\n"}, {"ä b", std::string("\0~", 2)}};
    EXPECT_EQ(parse_fields(fields_text(fields)), fields);
    EXPECT_EQ(fields_text({{"fault", "x.h5: 5 %, µ"}}), "fault=x.h5%3A+5+%25%2C+%C2%B5");
}

TEST(Fields, AreRefusedWhereTheyAreNotWellFormed) {
    for (const auto *text : {"a=%", "a=%2", "a=%zz", "a=%-1", "%=1", "a=1&a=1"})
        EXPECT_THROW(parse_fields(text), support::InputError) << text;
}

TEST(Fields, GiveTheNumbersBetweenCommas) {
    EXPECT_EQ(required_numbers({{"x", "1"}}, "x"), std::vector{1.0});
    EXPECT_EQ(required_numbers({{"x", "-1e-3,0,2.5"}}, "x"), (std::vector{-1e-3, 0.0, 2.5}));
    for (const auto *value : {"", ",", "1,", ",1", "1,,2", "1,x", "1 ,2", "nan", "1,inf", "1e999"})
        EXPECT_THROW(required_numbers({{"x", value}}, "x"), support::InputError) << value;
}

TEST(Fields, GiveNumbersOfTheirRangeOnly) {
    EXPECT_EQ(required_number({{"e", "4e3"}}, "e", 1.0, 1e9), 4000.0);
    EXPECT_EQ(required_number({{"nu", "0"}}, "nu", 0.0, 0.49), 0.0);
    for (const auto *value : {"", " 1", "1 ", "1x", "x", "nan", "inf", "-inf", "0.49999", "-1e-300", "1e999", "0x1"})
        EXPECT_THROW(required_number({{"nu", value}}, "nu", 0.0, 0.49), support::InputError) << value;
    EXPECT_THROW(required_number({{"n", "0"}}, "nu", 0.0, 0.49), support::InputError);
    EXPECT_EQ(required_text({{"file", "a"}}, "file"), "a");
    EXPECT_THROW(required_text({{"file", ""}}, "file"), support::InputError);
}

} // namespace
} // namespace livermark::server
