#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <list>
#include <set>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "app/server/site.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/child.hpp"
#include "tests/listening_sockets.hpp"
#include "tests/samples/small_bar.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/web_client.hpp"

namespace livermark::server {
namespace {

namespace http = boost::beast::http;
using boost::asio::ip::tcp;
using namespace std::chrono_literals;

/// serve() in a process of its own, which has few descriptors left.
class CrowdedServer {
  public:
    explicit CrowdedServer(int num_descriptors) {
        int ends[2];
        if (pipe(ends) != 0)
            return;
        process_ = fork();
        if (process_ == 0)
            be_served(num_descriptors, ends[1]);
        close(ends[1]);
        if (read(ends[0], &port, sizeof(port)) != sizeof(port))
            port = 0;
        close(ends[0]);
    }
    ~CrowdedServer() {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
    }
    CrowdedServer(const CrowdedServer &) = delete;
    CrowdedServer &operator=(const CrowdedServer &) = delete;

    /// Processor time of the process so far [s].
    double processor_time() const {
        std::ifstream file(fmt::format("/proc/{}/stat", process_));
        std::string text((std::istreambuf_iterator<char>(file)), {});
        std::istringstream rest(text.substr(text.rfind(')') + 1));
        std::string word;
        for (int field = 3; field < 14; ++field)
            rest >> word;
        double user = 0.0, system = 0.0;
        rest >> user >> system;
        return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
    }

    std::uint16_t port = 0;

  private:
    [[noreturn]] static void be_served(int num_descriptors, int out) {
        serve(tests::empty_site(), [&](std::uint16_t listening) {
            const int first_free = dup(out);
            const rlimit limit{static_cast<rlim_t>(first_free + num_descriptors),
                               static_cast<rlim_t>(first_free + num_descriptors)};
            close(first_free);
            setrlimit(RLIMIT_NOFILE, &limit);
            if (write(out, &listening, sizeof(listening)) < 0)
                _exit(1);
        });
        _exit(0);
    }

    pid_t process_ = -1;
};

/// Connections that read nothing, and say what they are told to.
class Crowd {
  public:
    explicit Crowd(std::uint16_t port) : port_(port) {}
    void grow(int number, const std::string &first_words = {}) {
        for (int i = 0; i < number; ++i) {
            auto &socket = sockets_.emplace_back(context_);
            boost::system::error_code error;
            socket.open(tcp::v4(), error);
            constexpr int few_bytes = 4096; // what is not read has to stay with the server
            socket.set_option(boost::asio::socket_base::receive_buffer_size(few_bytes), error);
            socket.connect({boost::asio::ip::address_v4::loopback(), port_}, error);
            socket.non_blocking(true, error); // a server that does not take all of it keeps nobody waiting
            boost::asio::write(socket, boost::asio::buffer(first_words), error);
        }
    }

  private:
    std::uint16_t port_;
    boost::asio::io_context context_;
    std::list<tcp::socket> sockets_;
};

/// 404: there is no such file, and somebody says so.
int status_of_a_new_request(std::uint16_t port) {
    auto request = tests::upgrade(port, "/files/none.h5");
    request.erase(http::field::upgrade);
    request.erase(http::field::connection);
    return tests::status_of(request, port);
}

/// Part of the seconds of a clock that a server is at work while nobody asks it anything.
double busy_part(const CrowdedServer &server) {
    const auto start = std::chrono::steady_clock::now();
    const double before = server.processor_time();
    std::this_thread::sleep_for(2s);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    return (server.processor_time() - before) / passed.count();
}

TEST(Crowd, OfSilentConnectionsDoesNotKeepOthersOut) {
    const CrowdedServer server(1000);
    ASSERT_NE(server.port, 0);
    Crowd crowd(server.port);
    crowd.grow(300);
    EXPECT_EQ(status_of_a_new_request(server.port), 404);
    crowd.grow(100, "GET / HTTP/1.1\r\nHost: ");
    EXPECT_EQ(status_of_a_new_request(server.port), 404);
}

TEST(Crowd, ThatAsksAndDoesNotReadTheRepliesDoesNotKeepOthersOut) {
    const CrowdedServer server(1000);
    ASSERT_NE(server.port, 0);
    std::string many_requests;
    for (int i = 0; i < 10000; ++i)
        many_requests += "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
    Crowd crowd(server.port);
    crowd.grow(70, many_requests);
    // Their replies, several megabytes for each, fill what the system keeps of a connection.
    while (busy_part(server) > 0.1)
        ;
    EXPECT_EQ(status_of_a_new_request(server.port), 404);
}

TEST(Crowd, ThatTakesAllDescriptorsNeitherKeepsOthersOutNorTheServerBusy) {
    const CrowdedServer server(12);
    ASSERT_NE(server.port, 0);
    Crowd crowd(server.port);
    crowd.grow(40);
    EXPECT_LT(busy_part(server), 0.3);
    EXPECT_EQ(status_of_a_new_request(server.port), 404);
}

TEST(Crowd, IsTurnedAwayWhereThereIsNoDescriptorAtAll) {
    const CrowdedServer server(0);
    ASSERT_NE(server.port, 0);
    Crowd crowd(server.port);
    crowd.grow(5);
    EXPECT_LT(busy_part(server), 0.3);
}

} // namespace
} // namespace livermark::server

namespace livermark {
namespace {

namespace fs = std::filesystem;
using boost::asio::ip::tcp;

/// By conjugate gradients with algebraic multigrid, which run on MPI.
core::Solution solved_by_iterations() {
    const auto body = tests::make_body(tests::box_mesh({0.06, 0.02, 0.02}, {6, 2, 2}), {1000.0, 5000.0, 0.3});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {100.0, 0.0, 0.0});
    return fem_reference::solve_static({body, load_case}, 2, fem_reference::SolverChoice::iterative);
}

TEST(Listening, StartsWithNobodyForAnIterativeSolveInOneProcess) {
    // That it would be found: this is what a library opens.
    boost::asio::io_context context;
    {
        const tcp::acceptor everywhere(context, {tcp::v6(), 0});
        EXPECT_EQ(tests::listening(getpid()).size(), 1U);
    }
    ASSERT_EQ(setenv("OMPI_MCA_btl", "self,tcp", 1), 0);
    // A folder of all processes would be made in there; one that ends takes it away from another that starts.
    const auto temporary = fs::path(testing::TempDir()) / "livermark_mpi";
    fs::remove_all(temporary);
    fs::create_directories(temporary);
    ASSERT_EQ(setenv("TMPDIR", temporary.c_str(), 1), 0);
    const auto solution = solved_by_iterations();
    unsetenv("TMPDIR");
    EXPECT_TRUE(fs::is_empty(temporary));
    EXPECT_EQ(solution.status, core::SolutionStatus::ok);
    EXPECT_NE(solution.solver.find("ML"), std::string::npos) << solution.solver;
    EXPECT_EQ(tests::listening(getpid()), std::set<std::string>{});
    EXPECT_EQ(tests::descendants(getpid()), std::set<pid_t>{});
    EXPECT_STREQ(getenv("OMPI_MCA_btl"), "self,tcp");
    EXPECT_EQ(getenv("OMPI_MCA_ess_singleton_isolated"), nullptr);
    unsetenv("OMPI_MCA_btl");
}

TEST(Listening, DuringARunIsNobody) {
    const auto folder = tests::folder_with_bar("listening");
    const auto pull = tests::write_pull(folder);
    std::set<std::string> heard;
    std::size_t num_looks = 0;
    const auto look = [&] {
        for (const auto process : tests::descendants(getpid())) {
            heard.merge(tests::listening(process));
            ++num_looks;
        }
        return false;
    };
    const auto end = tests::run_child({LIVERMARK_BINARY, "run", "--body", (folder / "bar.toml").string(), "--load-case",
                                       pull, "--model", "fem_p2", "--fem-solver", "iterative", "--reference-on-mesh",
                                       "--output", (folder / "runs").string()},
                                      {.killed_when = look});
    EXPECT_EQ(end.status, 0) << end.output << end.errors;
    EXPECT_GT(num_looks, 10U);
    EXPECT_EQ(heard, std::set<std::string>{});
}

TEST(Listening, OfTheServerIsOneSocketForThisMachineThatItsChildrenDoNotGet) {
    const tests::ServedInThread served(tests::empty_site(
        {{"/solve", [](const server::Fields &, const server::ReportProgress &) {
              return [](const server::Message &) -> server::Message { return {false, solved_by_iterations().solver}; };
          }}}));
    const std::set<std::string> own{fmt::format("0100007F:{:04X}", served.port)};
    tests::WebSocketClient client(served.port);
    ASSERT_TRUE(client.open("/solve"));
    EXPECT_NE(client.reply_to("go").find("ML"), std::string::npos);
    EXPECT_EQ(tests::listening(getpid()), own);
    // A child, while connections are open: `sleep` has what is not closed on exec.
    const auto process = fork();
    if (process == 0) {
        execlp("sleep", "sleep", "30", static_cast<char *>(nullptr));
        _exit(1);
    }
    std::string name;
    while (name != "sleep")
        std::ifstream(fmt::format("/proc/{}/comm", process)) >> name;
    EXPECT_EQ(tests::listening(process), std::set<std::string>{});
    std::set<std::string> sockets_of_child;
    for (const auto &entry : fs::directory_iterator(fmt::format("/proc/{}/fd", process)))
        if (const auto target = fs::read_symlink(entry.path()).string(); target.starts_with("socket:"))
            sockets_of_child.insert(target);
    kill(process, SIGKILL);
    EXPECT_LE(sockets_of_child.size(), 1U); // the client's of this test, which is in the same process
}

} // namespace
} // namespace livermark
